//! The description of a video track, the same for all containers.

use crate::video::fault::Fault;
use crate::yuv::Colour;
use fingervision_image::{Image, Pixels};

/// The video track of a file: how it is coded and where its frames lie.
#[derive(Debug)]
pub(crate) struct Track {
    pub(crate) codec: Codec,
    /// The compressed frames in the order in which they are decoded.
    pub(crate) samples: Vec<Sample>,
    pub(crate) turn: Turn,
    /// The file ends earlier than its index or its stated size.
    pub(crate) is_cut_off: bool,
}

/// How frames are compressed.
#[derive(Debug)]
pub(crate) enum Codec {
    /// H.264, with the content of the `avcC` box and what the container says about colour.
    H264 { config: Vec<u8>, colour: Option<Colour> },
    /// Every frame a JPEG.
    MotionJpeg,
}

/// One compressed frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sample {
    /// Where it starts in the file, bytes.
    pub(crate) offset: u64,
    /// Its length, bytes.
    pub(crate) len: u32,
    /// `None`: decoded because others build on it, but not part of the film.
    pub(crate) shown: Option<Shown>,
}

/// A frame's place in the film.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shown {
    pub(crate) sequence: u64,
    /// Presentation time, s.
    pub(crate) time_s: f64,
}

/// The rotation that makes the stored picture upright.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Turn {
    None,
    Clockwise,
    Half,
    Counterclockwise,
}

impl Turn {
    /// The turn that a matrix `[a b; c d]` writes, where a row vector `(x, y)` times the matrix is the upright place.
    pub(crate) fn from_matrix([a, b, c, d]: [i32; 4]) -> Result<Self, Fault> {
        match [a, b, c, d].map(i32::signum) {
            [1, 0, 0, 1] => Ok(Self::None),
            [0, 1, -1, 0] => Ok(Self::Clockwise),
            [-1, 0, 0, -1] => Ok(Self::Half),
            [0, -1, 1, 0] => Ok(Self::Counterclockwise),
            _ => Err(Fault::NotRead("a mirrored or slanted picture".into())),
        }
    }

    /// The picture upright.
    pub(crate) fn apply(self, pixels: Pixels) -> Pixels {
        match pixels {
            pixels if self == Self::None => pixels,
            Pixels::Grey8(image) => Pixels::Grey8(self.turned(&image)),
            Pixels::Rgb8(image) => Pixels::Rgb8(self.turned(&image)),
            Pixels::Grey16(image) => Pixels::Grey16(self.turned(&image)),
            Pixels::Rgb16(image) => Pixels::Rgb16(self.turned(&image)),
        }
    }

    fn turned<T: Copy>(self, image: &Image<T>) -> Image<T> {
        let (width, height) = image.size();
        match self {
            Self::None => Image::from_fn(width, height, |x, y| image.at(x, y)),
            Self::Clockwise => Image::from_fn(height, width, |x, y| image.at(y, height - 1 - x)),
            Self::Half => Image::from_fn(width, height, |x, y| image.at(width - 1 - x, height - 1 - y)),
            Self::Counterclockwise => Image::from_fn(height, width, |x, y| image.at(width - 1 - y, x)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clockwise_turn_moves_the_top_left_to_the_top_right() {
        let image = Pixels::Grey8(Image::from_fn(3, 2, |x, y| (10 * y + x) as u8));
        let Pixels::Grey8(turned) = Turn::Clockwise.apply(image.clone()) else { panic!("the format stays") };
        assert_eq!(turned.size(), (2, 3));
        assert_eq!(turned.values(), [10, 0, 11, 1, 12, 2]);
        let back = Turn::Counterclockwise.apply(Pixels::Grey8(turned));
        assert_eq!(back, image);
        assert_eq!(Turn::Half.apply(Turn::Half.apply(image.clone())), image);
    }
}

//! The frame: the output of a source and the input of a tracker.

use crate::Image;

/// One captured image and when it was taken.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Number in the source's own count, from 0; a gap means frames that the source dropped.
    pub sequence: u64,
    /// Time of the exposure, in seconds on the source's own clock.
    pub capture_time_s: f64,
    /// The image.
    pub pixels: Pixels,
}

/// The pixel formats of sources.
#[derive(Debug, Clone, PartialEq)]
pub enum Pixels {
    /// 8-bit grey.
    Grey8(Image<u8>),
    /// 8-bit red, green, blue.
    Rgb8(Image<[u8; 3]>),
    /// 16-bit grey.
    Grey16(Image<u16>),
    /// 16-bit red, green, blue.
    Rgb16(Image<[u16; 3]>),
}

impl Pixels {
    /// Columns and rows, px.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        match self {
            Self::Grey8(image) => image.size(),
            Self::Rgb8(image) => image.size(),
            Self::Grey16(image) => image.size(),
            Self::Rgb16(image) => image.size(),
        }
    }

    /// Whether there is more than one channel.
    #[must_use]
    pub fn is_colour(&self) -> bool {
        matches!(self, Self::Rgb8(_) | Self::Rgb16(_))
    }

    /// The channels at column `x`, row `y`, as grey levels 0 to 255; a grey pixel repeats its value.
    ///
    /// # Panics
    ///
    /// If the pixel lies outside the image.
    #[must_use]
    pub fn levels(&self, x: usize, y: usize) -> [f32; 3] {
        match self {
            Self::Grey8(image) => [f32::from(image.at(x, y)); 3],
            Self::Rgb8(image) => image.at(x, y).map(f32::from),
            Self::Grey16(image) => [f32::from(image.at(x, y)) / 257.0; 3],
            Self::Rgb16(image) => image.at(x, y).map(|value| f32::from(value) / 257.0),
        }
    }
}

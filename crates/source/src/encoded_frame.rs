//! A frame that is not decoded yet.

use crate::{CameraCoding, CameraLayout};
use fingervision_image::{Frame, Pixels};

/// A frame as a camera sent it: its bytes, with its number and its time.
///
/// Frames that were decoded already, as those of files, have their pixels in the codings [`CameraCoding::Grey8`],
/// [`CameraCoding::Grey16`], [`CameraCoding::Rgb8`] and [`CameraCoding::Rgb16`], without padding.
/// [`CameraFrameDecoder`](crate::CameraFrameDecoder) gives the pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct EncodedFrame {
    /// Number in the source's own count, from 0; a gap means frames that the source dropped.
    pub sequence: u64,
    /// Time of the exposure, in seconds on the source's own clock.
    pub capture_time_s: f64,
    /// The layout of the bytes.
    pub layout: CameraLayout,
    /// The bytes.
    pub bytes: Vec<u8>,
}

impl EncodedFrame {
    /// A frame without bytes, to be filled.
    #[must_use]
    pub fn empty() -> Self {
        let layout = CameraLayout { coding: CameraCoding::Grey8, width: 0, height: 0, row_bytes: 0 };
        Self { sequence: 0, capture_time_s: 0.0, layout, bytes: Vec::new() }
    }

    /// Stores a decoded frame; allocates nothing if it is not larger than the previous one.
    pub fn load(&mut self, frame: &Frame) {
        let (width, height) = frame.pixels.size();
        let bytes = &mut self.bytes;
        bytes.clear();
        let coding = match &frame.pixels {
            Pixels::Grey8(image) => {
                bytes.extend_from_slice(image.values());
                CameraCoding::Grey8
            }
            Pixels::Rgb8(image) => {
                bytes.extend_from_slice(image.values().as_flattened());
                CameraCoding::Rgb8
            }
            Pixels::Grey16(image) => {
                bytes.extend(image.values().iter().flat_map(|value| value.to_le_bytes()));
                CameraCoding::Grey16
            }
            Pixels::Rgb16(image) => {
                bytes.extend(image.values().as_flattened().iter().flat_map(|value| value.to_le_bytes()));
                CameraCoding::Rgb16
            }
        };
        self.layout = CameraLayout { coding, width, height, row_bytes: 0 };
        (self.sequence, self.capture_time_s) = (frame.sequence, frame.capture_time_s);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CameraFrameDecoder;
    use fingervision_image::Image;

    #[test]
    fn pixels_come_back_as_they_were() {
        let value = |x: usize, y: usize| 1000 * x as u16 + 7 * y as u16;
        let all = [
            Pixels::Grey8(Image::from_fn(3, 2, |x, y| value(x, y) as u8)),
            Pixels::Grey16(Image::from_fn(3, 2, value)),
            Pixels::Rgb8(Image::from_fn(3, 2, |x, y| [x as u8, y as u8, 9])),
            Pixels::Rgb16(Image::from_fn(3, 2, |x, y| [value(x, y), 258, 3])),
        ];
        let mut encoded = EncodedFrame::empty();
        for pixels in all {
            encoded.load(&Frame { sequence: 4, capture_time_s: 0.5, pixels: pixels.clone() });
            assert_eq!((encoded.sequence, encoded.capture_time_s), (4, 0.5));
            let decoded = CameraFrameDecoder::new(encoded.layout).decode(&encoded.bytes).unwrap();
            assert_eq!(decoded, pixels);
        }
    }
}

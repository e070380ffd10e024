//! Motion JPEG: a video whose frames are JPEG pictures.

use crate::jpeg::decode_jpeg_into;
use fingervision_image::Pixels;

/// Motion JPEG: every sample is a picture of its own.
#[derive(Debug, Default)]
pub(crate) struct MotionJpeg {
    /// A picture with its tables, where they were missing.
    complete: Vec<u8>,
}

impl MotionJpeg {
    /// Decodes a sample, or the luma alone of one with luma and chroma, into pixels that are used again; after an error they
    /// have any values.
    pub(crate) fn decode_into(
        &mut self,
        sample: &[u8],
        is_luma_alone: bool,
        pixels: &mut Pixels,
    ) -> Result<(), String> {
        if add_standard_tables(sample, &mut self.complete) {
            decode_jpeg_into(&self.complete, is_luma_alone, pixels)
        } else {
            decode_jpeg_into(sample, is_luma_alone, pixels)
        }
    }
}

/// Completes a picture without Huffman tables, as many USB cameras send it, by a request for the standard ones; false if it
/// has its own.
///
/// The decoder has them, but uses them only after the marker that the AVI format requires and cameras omit.
fn add_standard_tables(sample: &[u8], complete: &mut Vec<u8>) -> bool {
    const START: [u8; 2] = [0xff, 0xd8];
    const AVI_MARKER: [u8; 18] = *b"\xff\xe0\0\x10AVI1\0\0\0\0\0\0\0\0\0\0";
    let find = |bytes: &[u8], marker: u8| bytes.windows(2).position(|pair| pair == [0xff, marker]);
    let Some(rest) = sample.strip_prefix(&START) else { return false };
    let Some(scan) = find(sample, 0xda) else { return false };
    if find(&sample[..scan], 0xc4).is_some() {
        return false;
    }
    complete.clear();
    complete.extend_from_slice(&START);
    complete.extend_from_slice(&AVI_MARKER);
    complete.extend_from_slice(rest);
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jpeg::decode_jpeg;
    use fingervision_image::Image;
    use image::codecs::jpeg::JpegEncoder;
    use image::{GrayImage, ImageBuffer, Luma};

    fn decoded(sample: &[u8]) -> Pixels {
        let mut pixels = Pixels::Grey8(Image::filled(0, 0, 0));
        MotionJpeg::default().decode_into(sample, false, &mut pixels).unwrap();
        pixels
    }

    #[test]
    fn a_camera_picture_without_huffman_tables_gets_the_standard_ones() {
        let picture: GrayImage = ImageBuffer::from_fn(24, 16, |x, y| Luma([(7 * x + 5 * y) as u8]));
        let mut whole = Vec::new();
        // This encoder writes the standard tables.
        JpegEncoder::new(&mut whole).encode_image(&picture).unwrap();
        let mut bare = whole.clone();
        while let Some(at) = bare.windows(2).position(|pair| pair == [0xff, 0xc4]) {
            let len = usize::from(u16::from_be_bytes([bare[at + 2], bare[at + 3]]));
            bare.drain(at..at + 2 + len);
        }
        assert!(bare.len() < whole.len());
        assert!(decode_jpeg(&bare).is_err());
        let wanted = decoded(&whole);
        assert!(matches!(wanted, Pixels::Grey8(_)));
        assert_eq!(decoded(&bare), wanted);
    }
}

//! Motion JPEG: a video whose frames are JPEG pictures.

use crate::decoder::Decoder;
use crate::jpeg::decode_jpeg;
use crate::picture::pixels;
use fingervision_image::Pixels;

/// Motion JPEG: every sample is a picture of its own.
pub(crate) struct MotionJpeg;

impl Decoder for MotionJpeg {
    fn decode(&mut self, sample: &[u8]) -> Result<Pixels, String> {
        let (image, _) = match with_standard_tables(sample) {
            Some(complete) => decode_jpeg(&complete)?,
            None => decode_jpeg(sample)?,
        };
        pixels(image)
    }

    fn is_key(&self, _: &[u8]) -> bool {
        true
    }
}

/// A picture without Huffman tables, as many USB cameras send it, with a request for the standard ones.
///
/// The decoder has them, but uses them only after the marker that the AVI format requires and cameras omit.
fn with_standard_tables(sample: &[u8]) -> Option<Vec<u8>> {
    const START: [u8; 2] = [0xff, 0xd8];
    const AVI_MARKER: [u8; 18] = *b"\xff\xe0\0\x10AVI1\0\0\0\0\0\0\0\0\0\0";
    let find = |marker: u8| sample.windows(2).position(|pair| pair == [0xff, marker]);
    let scan = find(0xda)?;
    let has_tables = find(0xc4).is_some_and(|tables| tables < scan);
    let rest = sample.strip_prefix(&START)?;
    (!has_tables).then(|| [&START, &AVI_MARKER[..], rest].concat())
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::codecs::jpeg::JpegEncoder;
    use image::{GrayImage, ImageBuffer, Luma};

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
        let wanted = MotionJpeg.decode(&whole).unwrap();
        assert!(matches!(wanted, Pixels::Grey8(_)));
        assert_eq!(MotionJpeg.decode(&bare).unwrap(), wanted);
    }
}

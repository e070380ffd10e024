//! JPEG pictures, in separate files and as the frames of a motion JPEG video.

use crate::picture::pixels;
use crate::video::Decoder;
use fingervision_image::Pixels;
use image::metadata::Orientation;
use image::{DynamicImage, GrayImage, RgbImage};
use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;

/// Decodes a JPEG to 8-bit grey or colour, and returns the orientation of the camera.
///
/// A picture without its end is refused: decoders may fill the missing rows with grey.
pub(crate) fn decode_jpeg(bytes: &[u8]) -> Result<(DynamicImage, Orientation), String> {
    if !is_whole(bytes) {
        return Err("the JPEG picture is cut off".into());
    }
    let reason = |error| format!("{error:?}");
    let options = DecoderOptions::default().set_strict_mode(true);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(reason)?;
    let is_grey = decoder.input_colorspace() == Some(ColorSpace::Luma);
    let output = if is_grey { ColorSpace::Luma } else { ColorSpace::RGB };
    decoder.set_options(options.jpeg_set_out_colorspace(output));
    let values = decoder.decode().map_err(reason)?;
    let info = decoder.info().ok_or("the JPEG picture has no size")?;
    let (width, height) = (u32::from(info.width), u32::from(info.height));
    let image = if is_grey {
        GrayImage::from_raw(width, height, values).map(DynamicImage::from)
    } else {
        RgbImage::from_raw(width, height, values).map(DynamicImage::from)
    };
    let orientation = decoder.exif().and_then(|exif| Orientation::from_exif_chunk(exif));
    Ok((image.ok_or("the JPEG picture lacks rows")?, orientation.unwrap_or(Orientation::NoTransforms)))
}

/// Whether an end-of-image marker follows the start of the last scan; a thumbnail's markers come before it.
fn is_whole(bytes: &[u8]) -> bool {
    let last = |marker: u8| bytes.windows(2).rposition(|pair| pair == [0xff, marker]);
    last(0xda) < last(0xd9)
}

/// Whether a second picture follows the first: the two fields of an interlaced frame.
///
/// A decoder stops after the first, and half of the rows would pass for the frame.
pub(crate) fn has_two_fields(sample: &[u8]) -> bool {
    let behind = end_of_picture(sample).and_then(|end| sample.get(end..)).unwrap_or_default();
    behind.windows(3).any(|start| start == [0xff, 0xd8, 0xff])
}

/// The end of the first picture, by its markers: a thumbnail's end lies within a segment that is skipped.
fn end_of_picture(picture: &[u8]) -> Option<usize> {
    let mut at = 2;
    loop {
        let marker = at + picture.get(at..)?.windows(2).position(|pair| pair[0] == 0xff && is_marker(pair[1]))?;
        let content = marker + 2;
        at = match picture[marker + 1] {
            0xd9 => return Some(content),
            _ => content + usize::from(u16::from_be_bytes([*picture.get(content)?, *picture.get(content + 1)?])),
        };
    }
}

/// Not a byte of coded data, not padding, and none of the markers without content that stand between rows.
fn is_marker(byte: u8) -> bool {
    !matches!(byte, 0x00 | 0xff | 0x01 | 0xd0..=0xd7)
}

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
    use image::{ImageBuffer, Luma};

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

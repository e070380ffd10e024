//! JPEG pictures, in files of their own and as the frames of a motion JPEG video.

use crate::picture::pixels;
use crate::video::Decoder;
use fingervision_image::Pixels;
use image::metadata::Orientation;
use image::{DynamicImage, GrayImage, RgbImage};
use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;

/// Decodes a JPEG to 8-bit grey or colour, and tells how the camera was held.
///
/// A picture without its end is refused: decoders like to fill the missing rows with grey.
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

/// Motion JPEG: every sample is a picture of its own.
pub(crate) struct MotionJpeg;

impl Decoder for MotionJpeg {
    fn decode(&mut self, sample: &[u8]) -> Result<Pixels, String> {
        decode_jpeg(sample).and_then(|(image, _)| pixels(image))
    }
}

//! JPEG pictures, in separate files and as the frames of a motion JPEG video.

use crate::reuse;
use fingervision_image::Pixels;
use image::metadata::Orientation;
use image::{DynamicImage, GrayImage, RgbImage};
use std::io::{self, BufRead, Read, Seek, SeekFrom};
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::{JpegDecoder, SampleRatios};

/// Decodes a JPEG to 8-bit grey or colour, and returns the orientation of the camera.
///
/// A picture without its end is refused: decoders may fill the missing rows with grey.
pub(crate) fn decode_jpeg(bytes: &[u8]) -> Result<(DynamicImage, Orientation), String> {
    let (mut decoder, is_grey) = opened(bytes, false)?;
    let values = decoder.decode().map_err(|error| in_words(&error))?;
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

/// As [`decode_jpeg`], but upright as it is stored, and into pixels that are used again. Of luma and chroma, luma alone is
/// decoded on request.
///
/// After an error the pixels have any values.
pub(crate) fn decode_jpeg_into(bytes: &[u8], is_luma_alone: bool, pixels: &mut Pixels) -> Result<(), String> {
    let (mut decoder, is_grey) = opened(bytes, is_luma_alone)?;
    let size = decoder.dimensions().ok_or("the JPEG picture has no size")?;
    let values = if is_grey { reuse::grey8(pixels, size) } else { reuse::rgb8(pixels, size).as_flattened_mut() };
    decoder.decode_into(values).map_err(|error| in_words(&error))
}

/// Whether these are the bytes of a JPEG that stores colour more coarsely than luma, as 4:2:0 and 4:2:2 do.
pub(crate) fn has_coarse_colour(bytes: &[u8]) -> bool {
    let mut decoder = JpegDecoder::new(Coded { bytes, at: 0 });
    decoder.decode_headers().is_ok() && decoder.info().is_some_and(|info| info.sample_ratio != SampleRatios::None)
}

type Decoder<'a> = JpegDecoder<Coded<'a>>;

/// The bytes of a picture. The decoder asks for four of them every few coefficients: without inlining, as by readers of the
/// libraries, a quarter of its time is spent here.
struct Coded<'a> {
    bytes: &'a [u8],
    /// The next byte; never behind the last one.
    at: usize,
}

impl Read for Coded<'_> {
    #[inline(always)]
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        let rest = &self.bytes[self.at..];
        let count = if let (Ok(to), Some(four)) = (<&mut [u8; 4]>::try_from(&mut *to), rest.first_chunk()) {
            *to = *four;
            4
        } else {
            let count = to.len().min(rest.len());
            to[..count].copy_from_slice(&rest[..count]);
            count
        };
        self.at += count;
        Ok(count)
    }
}

impl BufRead for Coded<'_> {
    #[inline(always)]
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        Ok(&self.bytes[self.at..])
    }

    #[inline(always)]
    fn consume(&mut self, count: usize) {
        self.at = (self.at + count).min(self.bytes.len());
    }
}

impl Seek for Coded<'_> {
    #[inline(always)]
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let (from, offset) = match to {
            SeekFrom::Start(at) => (0, i64::try_from(at).unwrap_or(i64::MAX)),
            SeekFrom::Current(offset) => (self.at, offset),
            SeekFrom::End(offset) => (self.bytes.len(), offset),
        };
        let at = (from as u64).checked_add_signed(offset).ok_or(io::ErrorKind::InvalidInput)?;
        self.at = self.bytes.len().min(usize::try_from(at).unwrap_or(usize::MAX));
        Ok(self.at as u64)
    }
}

/// A decoder behind the headers of a whole picture, and whether it gives grey.
fn opened(bytes: &[u8], is_luma_alone: bool) -> Result<(Decoder<'_>, bool), String> {
    if !is_whole(bytes) {
        return Err("the JPEG picture is cut off".into());
    }
    let options = DecoderOptions::default().set_strict_mode(true);
    let mut decoder = JpegDecoder::new_with_options(Coded { bytes, at: 0 }, options);
    decoder.decode_headers().map_err(|error| in_words(&error))?;
    let stored = decoder.input_colorspace();
    let is_grey = stored == Some(ColorSpace::Luma) || is_luma_alone && stored == Some(ColorSpace::YCbCr);
    let output = if is_grey { ColorSpace::Luma } else { ColorSpace::RGB };
    decoder.set_options(options.jpeg_set_out_colorspace(output));
    Ok((decoder, is_grey))
}

fn in_words(error: &DecodeErrors) -> String {
    format!("{error:?}")
}

/// Whether an end-of-image marker follows the start of the last scan; a thumbnail's markers come before it.
fn is_whole(bytes: &[u8]) -> bool {
    // The last of the two markers: it is usually at the end, and coded data contains neither.
    let last = bytes.windows(2).rfind(|pair| matches!(pair, [0xff, 0xd9 | 0xda]));
    last == Some(&[0xff, 0xd9])
}

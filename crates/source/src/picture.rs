//! Decodes one still image from the bytes of its file.

use crate::jpeg::decode_jpeg;
use fingervision_image::{Image, Pixels};
use image::metadata::Orientation;
use image::{DynamicImage, ImageBuffer, ImageDecoder, ImageError, ImageFormat, ImageReader};
use std::io::{self, Cursor, ErrorKind};
use tiff::decoder::{Decoder as TiffDecoder, DecodingResult};
use tiff::tags::Tag;
use tiff::{ColorType, TiffError};

/// The most memory that the pixels of one image may take, bytes.
const MAX_BYTES: u64 = 1 << 30;
/// The most bytes of pixels that a byte of a file can hold: deflate packs 1032 bytes into one, of which each is eight
/// pixels of three bytes where a pixel takes one bit.
const MOST_GROWTH: u64 = 1 << 15;
/// TIFF's code for floating-point samples.
const FLOATING_POINT: u16 = 3;

/// Why an image file cannot be read.
#[derive(Debug)]
pub(crate) enum PictureFault {
    /// Not a readable image, or not a complete one.
    Damaged(String),
    /// A floating-point value outside 0 to 1.
    Range { x: usize, y: usize, value: f64 },
}

impl From<ImageError> for PictureFault {
    fn from(error: ImageError) -> Self {
        match error {
            ImageError::IoError(error) => error.into(),
            error => Self::Damaged(error.to_string()),
        }
    }
}

impl From<TiffError> for PictureFault {
    fn from(error: TiffError) -> Self {
        match error {
            TiffError::IoError(error) => error.into(),
            error => Self::Damaged(error.to_string()),
        }
    }
}

/// Reading from memory fails only at its end.
impl From<io::Error> for PictureFault {
    fn from(error: io::Error) -> Self {
        Self::Damaged(match error.kind() {
            ErrorKind::UnexpectedEof => "the picture is cut off".into(),
            _ => error.to_string(),
        })
    }
}

impl From<String> for PictureFault {
    fn from(reason: String) -> Self {
        Self::Damaged(reason)
    }
}

/// Decodes PNG, JPEG, TIFF or BMP, recognised by content, and rotates the picture upright if the file gives its
/// orientation.
pub(crate) fn decode(bytes: &[u8]) -> Result<Pixels, PictureFault> {
    let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format()?;
    let (mut image, orientation) = match reader.format() {
        Some(ImageFormat::Jpeg) => decode_jpeg(bytes)?,
        Some(ImageFormat::Tiff) if has_more_pages(bytes) => {
            return Err(PictureFault::Damaged(
                "a TIFF of several pages is not read: write each page to a file of its own".into(),
            ));
        }
        Some(ImageFormat::Tiff) if is_float_tiff(bytes) => decode_float_tiff(bytes)?,
        Some(ImageFormat::Png | ImageFormat::Tiff | ImageFormat::Bmp) => {
            let mut decoder = reader.into_decoder()?;
            check_size(&decoder, bytes.len())?;
            let orientation = decoder.orientation()?;
            (DynamicImage::from_decoder(decoder)?, orientation)
        }
        _ => return Err(PictureFault::Damaged("not a PNG, JPEG, TIFF or BMP image".into())),
    };
    image.apply_orientation(orientation);
    Ok(pixels(image)?)
}

/// Refuses sizes that only a damaged file requests, before memory is allocated.
fn check_size(decoder: &impl ImageDecoder, file_len: usize) -> Result<(), PictureFault> {
    let (width, height) = decoder.dimensions();
    if decoder.total_bytes() > MAX_BYTES {
        return Err(PictureFault::Damaged(format!("an image of {width}x{height} px is too large")));
    }
    if decoder.total_bytes() > MOST_GROWTH.saturating_mul(file_len as u64) {
        let reason = format!("an image of {width}x{height} px does not fit into a file of {file_len} bytes");
        return Err(PictureFault::Damaged(reason));
    }
    Ok(())
}

/// Pixels with the depth of `image`; transparency is dropped.
pub(crate) fn pixels(image: DynamicImage) -> Result<Pixels, String> {
    let size = (image.width() as usize, image.height() as usize);
    match image {
        DynamicImage::ImageLuma8(image) => single(size, image.into_raw()).map(Pixels::Grey8),
        DynamicImage::ImageLuma16(image) => single(size, image.into_raw()).map(Pixels::Grey16),
        DynamicImage::ImageLumaA8(_) => single(size, image.into_luma8().into_raw()).map(Pixels::Grey8),
        DynamicImage::ImageLumaA16(_) => single(size, image.into_luma16().into_raw()).map(Pixels::Grey16),
        DynamicImage::ImageRgb8(_) | DynamicImage::ImageRgba8(_) => triple(size, &image.into_rgb8()).map(Pixels::Rgb8),
        DynamicImage::ImageRgb16(_) | DynamicImage::ImageRgba16(_) => {
            triple(size, &image.into_rgb16()).map(Pixels::Rgb16)
        }
        _ => Err("this kind of pixel is not supported".into()),
    }
}

fn single<T>(size: (usize, usize), values: Vec<T>) -> Result<Image<T>, String> {
    filled(size, values)
}

fn triple<T: Copy>(size: (usize, usize), values: &[T]) -> Result<Image<[T; 3]>, String> {
    filled(size, values.as_chunks().0.to_vec())
}

fn filled<T>((width, height): (usize, usize), values: Vec<T>) -> Result<Image<T>, String> {
    if values.is_empty() {
        return Err(format!("an image of {width}x{height} px has no pixels"));
    }
    Image::from_vec(width, height, values).map_err(|error| error.to_string())
}

fn has_more_pages(bytes: &[u8]) -> bool {
    TiffDecoder::new(Cursor::new(bytes)).is_ok_and(|tiff| tiff.more_images())
}

fn is_float_tiff(bytes: &[u8]) -> bool {
    let format =
        TiffDecoder::new(Cursor::new(bytes)).and_then(|mut tiff| tiff.find_tag_unsigned_vec(Tag::SampleFormat));
    matches!(format, Ok(Some(formats)) if formats.contains(&FLOATING_POINT))
}

/// Reads floating-point grey or colour, with or without transparency, and scales 0 to 1 up to 16 bit.
fn decode_float_tiff(bytes: &[u8]) -> Result<(DynamicImage, Orientation), PictureFault> {
    let mut tiff = TiffDecoder::new(Cursor::new(bytes))?;
    let (width, height) = tiff.dimensions()?;
    let (stored, used) = match tiff.colortype()? {
        ColorType::Gray(_) => (1, 1),
        ColorType::GrayA(_) => (2, 1),
        ColorType::RGB(_) => (3, 3),
        ColorType::RGBA(_) => (4, 3),
        other => {
            return Err(PictureFault::Damaged(format!(
                "floating-point TIFF pixels of kind {other:?} are not supported"
            )));
        }
    };
    if stored > 1 && tiff.find_tag_unsigned::<u16>(Tag::PlanarConfiguration)?.is_some_and(|planes| planes != 1) {
        return Err(PictureFault::Damaged("floating-point TIFF with separate colour planes is not supported".into()));
    }
    let orientation = tiff.find_tag_unsigned::<u8>(Tag::Orientation)?.and_then(Orientation::from_exif);
    let values = match tiff.read_image()? {
        DecodingResult::F32(values) => to_16_bit(&values, width as usize, stored, used)?,
        DecodingResult::F64(values) => to_16_bit(&values, width as usize, stored, used)?,
        _ => return Err(PictureFault::Damaged("floating-point TIFF of this depth is not supported".into())),
    };
    let image = if used == 1 {
        ImageBuffer::from_raw(width, height, values).map(DynamicImage::ImageLuma16)
    } else {
        ImageBuffer::from_raw(width, height, values).map(DynamicImage::ImageRgb16)
    };
    let image = image.ok_or_else(|| PictureFault::Damaged("the TIFF image lacks rows".into()))?;
    Ok((image, orientation.unwrap_or(Orientation::NoTransforms)))
}

/// Scales 0 to 1 to 0 to 65535 and keeps the first `used` of `stored` channels.
fn to_16_bit<T: Copy + Into<f64>>(
    values: &[T],
    width: usize,
    stored: usize,
    used: usize,
) -> Result<Vec<u16>, PictureFault> {
    let mut scaled = Vec::with_capacity(values.len() / stored * used);
    for (index, pixel) in values.chunks_exact(stored).enumerate() {
        for &value in &pixel[..used] {
            let value = value.into();
            if !(0.0..=1.0).contains(&value) {
                return Err(PictureFault::Range { x: index % width, y: index / width, value });
            }
            scaled.push((value * 65535.0).round() as u16);
        }
    }
    Ok(scaled)
}

//! Conversion of a frame's pixels to `f32` grey levels.

use crate::{Image, ImageError, Pixels, Rect};

/// Weights of red, green and blue in grey, dimensionless, summing to 1: ITU-R BT.601 luma.
pub const LUMA_WEIGHTS: [f32; 3] = [0.299, 0.587, 0.114];

/// Grey levels from 16-bit values.
const LEVELS_PER_VALUE_16: f32 = 1.0 / 257.0;

/// Writes the grey levels, 0 to 255, of a region of a frame.
///
/// Colour is reduced by [`LUMA_WEIGHTS`]. `grey` takes the region's size; it allocates only where that grows.
///
/// # Errors
///
/// [`ImageError::RegionOutside`] if the region reaches outside the frame.
pub fn grey_into(pixels: &Pixels, region: Rect, grey: &mut Image<f32>) -> Result<(), ImageError> {
    match pixels {
        Pixels::Grey8(image) => convert(image, region, grey, f32::from),
        Pixels::Rgb8(image) => convert_rows(image, region, grey, luma_row),
        Pixels::Grey16(image) => convert(image, region, grey, |value| f32::from(value) * LEVELS_PER_VALUE_16),
        Pixels::Rgb16(image) => convert(image, region, grey, |rgb| luma(rgb.map(f32::from)) * LEVELS_PER_VALUE_16),
    }
}

/// Writes red, green, blue and a zero, 0 to 255, of a region of a frame.
///
/// The fourth value makes a pixel one vector register. A grey frame repeats its value.
///
/// # Errors
///
/// [`ImageError::RegionOutside`] if the region reaches outside the frame.
pub fn rgbx_into(pixels: &Pixels, region: Rect, rgbx: &mut Image<[f32; 4]>) -> Result<(), ImageError> {
    match pixels {
        Pixels::Grey8(image) => convert(image, region, rgbx, |value| padded([value; 3].map(f32::from))),
        Pixels::Rgb8(image) => convert(image, region, rgbx, |rgb| padded(rgb.map(f32::from))),
        Pixels::Grey16(image) => {
            convert(image, region, rgbx, |value| padded([f32::from(value) * LEVELS_PER_VALUE_16; 3]))
        }
        Pixels::Rgb16(image) => {
            convert(image, region, rgbx, |rgb| padded(rgb.map(|value| f32::from(value) * LEVELS_PER_VALUE_16)))
        }
    }
}

fn luma([red, green, blue]: [f32; 3]) -> f32 {
    LUMA_WEIGHTS[0] * red + LUMA_WEIGHTS[1] * green + LUMA_WEIGHTS[2] * blue
}

/// The grey levels of a row, four pixels at once.
fn luma_row(row: &[[u8; 3]], grey: &mut [f32]) {
    let (blocks, rest) = row.as_chunks::<4>();
    let (grey_blocks, grey_rest) = grey.as_chunks_mut::<4>();
    for (pixels, grey) in blocks.iter().zip(grey_blocks) {
        let words = words(pixels);
        let channel = |mask: u32, scale: f32| words.map(|word| (word & mask).cast_signed() as f32 * scale);
        // Factors that are powers of two do not change the result.
        let [red, green, blue] = [channel(0xff, 1.0), channel(0xff00, 1.0 / 256.0), channel(0xff_0000, 1.0 / 65536.0)];
        *grey = std::array::from_fn(|k| luma([red[k], green[k], blue[k]]));
    }
    for (grey, &rgb) in grey_rest.iter_mut().zip(rest) {
        *grey = luma(rgb.map(f32::from));
    }
}

/// Red, green and blue of four pixels in the lower three bytes of a word each. The fourth byte is any value.
#[must_use]
#[inline(always)]
pub fn words(pixels: &[[u8; 3]; 4]) -> [u32; 4] {
    let bytes = pixels.as_flattened();
    // As a whole: single bytes would be loaded one by one.
    let word = |first: usize| bytes[first..].first_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes));
    [word(0), word(3), word(6), word(8) >> 8]
}

fn padded([red, green, blue]: [f32; 3]) -> [f32; 4] {
    [red, green, blue, 0.0]
}

fn convert<T: Copy, U: Copy + Default>(
    from: &Image<T>,
    region: Rect,
    to: &mut Image<U>,
    convert_pixel: impl Fn(T) -> U,
) -> Result<(), ImageError> {
    convert_rows(from, region, to, |from, to| {
        for (to, &from) in to.iter_mut().zip(from) {
            *to = convert_pixel(from);
        }
    })
}

fn convert_rows<T: Copy, U: Copy + Default>(
    from: &Image<T>,
    region: Rect,
    to: &mut Image<U>,
    convert_row: impl Fn(&[T], &mut [U]),
) -> Result<(), ImageError> {
    let (width, height) = from.size();
    if !region.is_inside(width, height) {
        return Err(ImageError::RegionOutside { region, width, height });
    }
    if to.size() != (region.width, region.height) {
        *to = Image::filled(region.width, region.height, U::default());
    }
    for (y, to) in to.rows_mut().enumerate() {
        convert_row(&from.row(region.y + y)[region.x..][..region.width], to);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_format_reads_on_the_same_scale() {
        let region = Rect::whole(1, 1);
        let formats = [
            Pixels::Grey8(Image::filled(1, 1, 51)),
            Pixels::Rgb8(Image::filled(1, 1, [51; 3])),
            Pixels::Grey16(Image::filled(1, 1, 51 * 257)),
            Pixels::Rgb16(Image::filled(1, 1, [51 * 257; 3])),
        ];
        for pixels in formats {
            let mut grey = Image::filled(1, 1, 0.0);
            let mut rgbx = Image::filled(1, 1, [0.0; 4]);
            grey_into(&pixels, region, &mut grey).unwrap();
            rgbx_into(&pixels, region, &mut rgbx).unwrap();
            assert!((grey.at(0, 0) - 51.0).abs() < 1e-4, "{pixels:?}");
            assert!(rgbx.at(0, 0)[..3].iter().all(|level| (level - 51.0).abs() < 1e-4), "{pixels:?}");
        }
    }

    #[test]
    fn a_region_is_cut_out() {
        let pixels = Pixels::Grey8(Image::from_fn(5, 4, |x, y| (10 * y + x) as u8));
        let mut grey = Image::filled(0, 0, 0.0);
        grey_into(&pixels, Rect { x: 2, y: 1, width: 2, height: 3 }, &mut grey).unwrap();
        assert_eq!(grey.values(), [12.0, 13.0, 22.0, 23.0, 32.0, 33.0]);
        let outside = Rect { x: 4, y: 0, width: 2, height: 1 };
        assert!(grey_into(&pixels, outside, &mut grey).is_err());
    }
}

//! Conversion of a frame's pixels to `f32` grey levels.

mod rows;

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
        Pixels::Rgb8(image) => {
            check(image, region)?;
            rows::grey_into(image, region, grey);
            Ok(())
        }
        Pixels::Grey16(image) => convert(image, region, grey, |value| f32::from(value) * LEVELS_PER_VALUE_16),
        Pixels::Rgb16(image) => convert(image, region, grey, |rgb| luma(rgb.map(f32::from)) * LEVELS_PER_VALUE_16),
    }
}

/// Writes the grey levels as [`grey_into`] does, and red, green and blue, 0 to 255, each into an image of its own.
///
/// A grey frame repeats its value. The images take the region's size; they allocate only where that grows.
///
/// # Errors
///
/// [`ImageError::RegionOutside`] if the region reaches outside the frame.
pub fn grey_and_channels_into(
    pixels: &Pixels,
    region: Rect,
    grey: &mut Image<f32>,
    channels: &mut [Image<f32>; 3],
) -> Result<(), ImageError> {
    match pixels {
        Pixels::Grey8(_) | Pixels::Grey16(_) => {
            grey_into(pixels, region, grey)?;
            for channel in channels {
                channel.copy_from(grey);
            }
            Ok(())
        }
        Pixels::Rgb8(image) => {
            check(image, region)?;
            rows::separate_into(image, region, grey, channels);
            Ok(())
        }
        Pixels::Rgb16(image) => {
            for (index, channel) in channels.iter_mut().enumerate() {
                convert(image, region, channel, |rgb| f32::from(rgb[index]) * LEVELS_PER_VALUE_16)?;
            }
            grey_into(pixels, region, grey)
        }
    }
}

#[inline(always)]
fn luma([red, green, blue]: [f32; 3]) -> f32 {
    LUMA_WEIGHTS[0] * red + LUMA_WEIGHTS[1] * green + LUMA_WEIGHTS[2] * blue
}

fn convert<T: Copy, U: Copy + Default>(
    from: &Image<T>,
    region: Rect,
    to: &mut Image<U>,
    convert_pixel: impl Fn(T) -> U,
) -> Result<(), ImageError> {
    check(from, region)?;
    to.set_size((region.width, region.height));
    for (y, to) in to.rows_mut().enumerate() {
        for (to, &from) in to.iter_mut().zip(&from.row(region.y + y)[region.x..]) {
            *to = convert_pixel(from);
        }
    }
    Ok(())
}

/// Checks that a region is inside an image.
fn check<T: Copy>(image: &Image<T>, region: Rect) -> Result<(), ImageError> {
    let (width, height) = image.size();
    if region.is_inside(width, height) { Ok(()) } else { Err(ImageError::RegionOutside { region, width, height }) }
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
            let mut channels = [(); 3].map(|()| Image::filled(1, 1, 0.0));
            grey_and_channels_into(&pixels, region, &mut grey, &mut channels).unwrap();
            assert!((grey.at(0, 0) - 51.0).abs() < 1e-4, "{pixels:?}");
            assert!(channels.iter().all(|channel| (channel.at(0, 0) - 51.0).abs() < 1e-4), "{pixels:?}");
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

    #[test]
    fn channels_are_separated_in_rows_of_any_length() {
        let image = Image::from_fn(23, 9, |x, y| [(11 * x + y) as u8, (250 - 7 * x) as u8, (29 * y + 3 * x) as u8]);
        let region = Rect { x: 2, y: 1, width: 19, height: 7 };
        let mut channels = [(); 3].map(|()| Image::filled(0, 0, 0.0));
        let (mut grey, mut expected) = (Image::filled(0, 0, 0.0), Image::filled(0, 0, 0.0));
        let pixels = Pixels::Rgb8(image.clone());
        grey_and_channels_into(&pixels, region, &mut grey, &mut channels).unwrap();
        grey_into(&pixels, region, &mut expected).unwrap();
        assert_eq!(grey, expected);
        for (k, channel) in channels.iter().enumerate() {
            let level = |x: usize, y: usize| f32::from(image.at(region.x + x, region.y + y)[k]);
            assert_eq!(channel, &Image::from_fn(region.width, region.height, level));
        }
    }
}

//! Rows of 8-bit colour, eight pixels at a time.

use super::{LUMA_WEIGHTS, luma};
use crate::{Image, Rect};
use fearless_simd::{Level, dispatch, f32x8, i32x8, prelude::*};

/// Pixels that are converted together.
const LANES: usize = 8;

/// Writes the grey levels of a region, which must be inside the image.
pub(super) fn grey_into(image: &Image<[u8; 3]>, region: Rect, grey: &mut Image<f32>) {
    grey.set_size((region.width, region.height));
    dispatch!(Level::new(), simd => grey_rows(simd, image, region, grey));
}

/// Writes the grey levels of a region, which must be inside the image, and each of its channels.
pub(super) fn separate_into(
    image: &Image<[u8; 3]>,
    region: Rect,
    grey: &mut Image<f32>,
    channels: &mut [Image<f32>; 3],
) {
    grey.set_size((region.width, region.height));
    for channel in channels.iter_mut() {
        channel.set_size((region.width, region.height));
    }
    dispatch!(Level::new(), simd => separate_rows(simd, image, region, grey, channels));
}

#[inline(always)]
fn grey_rows<S: Simd>(simd: S, image: &Image<[u8; 3]>, region: Rect, grey: &mut Image<f32>) {
    for (y, grey) in grey.rows_mut().enumerate() {
        let (blocks, rest) = row_of(image, region, y);
        let (grey, grey_rest) = grey.as_chunks_mut::<LANES>();
        for (pixels, grey) in blocks.iter().zip(grey) {
            luma_of(levels(simd, pixels)).store_array(grey);
        }
        for (grey, &rgb) in grey_rest.iter_mut().zip(rest) {
            *grey = luma(rgb.map(f32::from));
        }
    }
}

#[inline(always)]
fn separate_rows<S: Simd>(
    simd: S,
    image: &Image<[u8; 3]>,
    region: Rect,
    grey: &mut Image<f32>,
    channels: &mut [Image<f32>; 3],
) {
    let [red, green, blue] = channels.each_mut().map(Image::rows_mut);
    let lines = grey.rows_mut().zip(red).zip(green.zip(blue));
    for (y, ((grey, red), (green, blue))) in lines.enumerate() {
        let (blocks, rest) = row_of(image, region, y);
        let [(grey, grey_rest), (red, red_rest), (green, green_rest), (blue, blue_rest)] =
            [grey, red, green, blue].map(|line| line.as_chunks_mut::<LANES>());
        let lines = grey.iter_mut().zip(red).zip(green.iter_mut().zip(blue));
        for (pixels, ((grey, red), (green, blue))) in blocks.iter().zip(lines) {
            let levels = levels(simd, pixels);
            luma_of(levels).store_array(grey);
            levels[0].store_array(red);
            levels[1].store_array(green);
            levels[2].store_array(blue);
        }
        let lines = grey_rest.iter_mut().zip(red_rest).zip(green_rest.iter_mut().zip(blue_rest));
        for (&rgb, ((grey, red), (green, blue))) in rest.iter().zip(lines) {
            let levels = rgb.map(f32::from);
            *grey = luma(levels);
            [*red, *green, *blue] = levels;
        }
    }
}

/// The pixels of a region's row, in blocks and what is left.
#[inline(always)]
fn row_of(image: &Image<[u8; 3]>, region: Rect, y: usize) -> (&[[[u8; 3]; LANES]], &[[u8; 3]]) {
    image.row(region.y + y)[region.x..][..region.width].as_chunks()
}

/// Red, green and blue of the pixels.
#[inline(always)]
fn levels<S: Simd>(simd: S, pixels: &[[u8; 3]; LANES]) -> [f32x8<S>; 3] {
    let words = i32x8::from_slice(simd, &words(pixels));
    // Factors that are powers of two do not change the result.
    [
        (words & 0xff).to_float::<f32x8<S>>(),
        (words & 0xff00).to_float::<f32x8<S>>() * (1.0 / 256.0),
        (words & 0xff_0000).to_float::<f32x8<S>>() * (1.0 / 65536.0),
    ]
}

/// The same sums in the same order as [`luma`].
#[inline(always)]
fn luma_of<S: Simd>([red, green, blue]: [f32x8<S>; 3]) -> f32x8<S> {
    red * LUMA_WEIGHTS[0] + green * LUMA_WEIGHTS[1] + blue * LUMA_WEIGHTS[2]
}

/// Red, green and blue of the pixels in the lower three bytes of a word each. The fourth byte is any value.
#[inline(always)]
fn words(pixels: &[[u8; 3]; LANES]) -> [i32; LANES] {
    let bytes = pixels.as_flattened();
    // As a whole: single bytes would be loaded one by one.
    let word = |first: usize| bytes[first..].first_chunk().map_or(0, |bytes| i32::from_le_bytes(*bytes));
    [word(0), word(3), word(6), word(9), word(12), word(15), word(18), word(20) >> 8]
}

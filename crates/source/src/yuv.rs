//! Converts luma and subsampled chroma to red, green and blue.
//!
//! A colour matrix is fixed by the weights `Kr` and `Kb` of red and blue in luma (ITU-T H.273, table 4). With luma `Y`
//! and chroma `U`, `V` on their full scales,
//!
//! ```text
//! R = Y + 2(1 − Kr)·V        B = Y + 2(1 − Kb)·U        G = (Y − Kr·R − Kb·B) / (1 − Kr − Kb)
//! ```
//!
//! Limited range spans 16 to 235 in luma and 16 to 240 in chroma. Chroma is interpolated linearly. Its samples lie in
//! the column of the even luma samples and, where rows are halved too, midway between two rows: H.264's own default.

#[cfg(any(feature = "video", test))]
use fingervision_image::Image;

/// Fixed-point one: coefficients carry 16 bits after the point.
const ONE: f64 = 65536.0;
/// Interpolated chroma carries three bits: a half across times a quarter down.
const CHROMA_BITS: u32 = 3;

/// How luma and chroma were made from red, green and blue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Colour {
    /// The matrix, by its number in ITU-T H.273.
    pub(crate) matrix: u16,
    /// Luma spans 0 to 255, not 16 to 235.
    pub(crate) is_full_range: bool,
}

/// A picture as luma and chroma, 8 bits each, row after row. Chroma has half of the columns.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Planes<'a> {
    pub(crate) y: &'a [u8],
    pub(crate) u: &'a [u8],
    pub(crate) v: &'a [u8],
    /// Columns and rows of chroma.
    pub(crate) chroma_size: [usize; 2],
    /// Chroma has half of the rows (4:2:0), not all of them (4:2:2).
    pub(crate) has_half_rows: bool,
}

/// Converts the pictures of one stream; owns its scratch.
pub(crate) struct YuvToRgb {
    width: usize,
    height: usize,
    luma_offset: i32,
    luma_gain: i32,
    red_from_v: i32,
    green_from_u: i32,
    green_from_v: i32,
    blue_from_u: i32,
    /// One row of chroma at full width, `[U, V]`, times 8, zero where there is no colour.
    chroma_row: Vec<[i32; 2]>,
}

impl YuvToRgb {
    /// A conversion for pictures of this size, px; `None` if the matrix is not a luma–chroma one.
    pub(crate) fn new(width: usize, height: usize, colour: Colour) -> Option<Self> {
        let (kr, kb) = match colour.matrix {
            1 => (0.2126, 0.0722),
            // 2 means "not said".
            2 | 5 | 6 => (0.299, 0.114),
            4 => (0.30, 0.11),
            7 => (0.212, 0.087),
            9 => (0.2627, 0.0593),
            _ => return None,
        };
        let kg = 1.0 - kr - kb;
        let (luma_offset, luma_gain, chroma_gain) =
            if colour.is_full_range { (0, 1.0, 1.0) } else { (16, 255.0 / 219.0, 255.0 / 224.0) };
        let fixed = |value: f64| (value * ONE).round() as i32;
        Some(Self {
            width,
            height,
            luma_offset,
            luma_gain: fixed(luma_gain),
            red_from_v: fixed(chroma_gain * 2.0 * (1.0 - kr)),
            green_from_u: fixed(-chroma_gain * 2.0 * (1.0 - kb) * kb / kg),
            green_from_v: fixed(-chroma_gain * 2.0 * (1.0 - kr) * kr / kg),
            blue_from_u: fixed(chroma_gain * 2.0 * (1.0 - kb)),
            chroma_row: vec![[0; 2]; width],
        })
    }

    /// Converts an 8-bit picture of the stream's size.
    #[cfg(any(feature = "video", test))]
    pub(crate) fn convert(&mut self, picture: &Planes) -> Result<Image<[u8; 3]>, String> {
        let mut rgb = Image::filled(self.width, self.height, [0; 3]);
        self.convert_into(picture, rgb.values_mut()).map(|()| rgb)
    }

    /// Converts an 8-bit picture into the values of an image of the stream's size.
    pub(crate) fn convert_into(&mut self, picture: &Planes, rgb: &mut [[u8; 3]]) -> Result<(), String> {
        let (width, height) = (self.width, self.height);
        let [chroma_width, chroma_height] = picture.chroma_size;
        let chroma_len = chroma_width * chroma_height;
        let is_whole = picture.y.len() == width * height && picture.u.len().min(picture.v.len()) == chroma_len;
        if !is_whole || chroma_len == 0 {
            return Err("the decoded picture lacks rows".into());
        }
        for ((row, luma), rgb) in picture.y.chunks_exact(width).enumerate().zip(rgb.chunks_exact_mut(width)) {
            self.interpolate_chroma(picture, row);
            let pixels = luma.iter().zip(&self.chroma_row);
            rgb.iter_mut().zip(pixels).for_each(|(rgb, (&luma, &chroma))| *rgb = self.pixel(luma, chroma));
        }
        Ok(())
    }

    /// Fills the chroma of one luma row.
    fn interpolate_chroma(&mut self, picture: &Planes, row: usize) {
        let [width, height] = picture.chroma_size;
        let last = height - 1;
        let (near, far) = match row / 2 {
            _ if !picture.has_half_rows => (row.min(last), row.min(last)),
            // Each luma row lies a quarter row from the nearest chroma row, on alternating sides.
            half if row.is_multiple_of(2) => (half.min(last), half.saturating_sub(1)),
            half => (half.min(last), (half + 1).min(last)),
        };
        let down = |plane: &[u8], column: usize| {
            3 * i32::from(plane[near * width + column]) + i32::from(plane[far * width + column]) - 4 * 128
        };
        let mut left = [down(picture.u, 0), down(picture.v, 0)];
        for (column, pair) in self.chroma_row.chunks_mut(2).enumerate() {
            let next = (column + 1).min(width - 1);
            let right = [down(picture.u, next), down(picture.v, next)];
            pair[0] = [2 * left[0], 2 * left[1]];
            if let Some(between) = pair.get_mut(1) {
                *between = [left[0] + right[0], left[1] + right[1]];
            }
            left = right;
        }
    }

    fn pixel(&self, luma: u8, [u, v]: [i32; 2]) -> [u8; 3] {
        let luma = ((i32::from(luma) - self.luma_offset) * self.luma_gain) << CHROMA_BITS;
        let level = |value: i32| {
            let shift = 16 + CHROMA_BITS;
            ((value + (1 << (shift - 1))) >> shift).clamp(0, 255) as u8
        };
        let red = luma + self.red_from_v * v;
        let green = luma + self.green_from_u * u + self.green_from_v * v;
        let blue = luma + self.blue_from_u * u;
        [level(red), level(green), level(blue)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rows of chroma of a picture of 4×4 px, with half of the rows or all.
    fn planes<'a>(y: &'a [u8; 16], u: &'a [u8; 8], v: &'a [u8; 8], has_half_rows: bool) -> Planes<'a> {
        let rows = if has_half_rows { 2 } else { 4 };
        Planes { y, u: &u[..2 * rows], v: &v[..2 * rows], chroma_size: [2, rows], has_half_rows }
    }

    /// The definition, in `f64`.
    fn reference(rgb: [f64; 3], kr: f64, kb: f64, full: bool) -> [u8; 3] {
        let [r, g, b] = rgb;
        let y = kr * r + (1.0 - kr - kb) * g + kb * b;
        let (u, v) = ((b - y) / (2.0 * (1.0 - kb)), (r - y) / (2.0 * (1.0 - kr)));
        let stored = if full {
            [255.0 * y, 128.0 + 255.0 * u, 128.0 + 255.0 * v]
        } else {
            [16.0 + 219.0 * y, 128.0 + 224.0 * u, 128.0 + 224.0 * v]
        };
        stored.map(|value| value.round().clamp(0.0, 255.0) as u8)
    }

    #[test]
    fn every_matrix_and_range_gives_back_the_colour_it_was_made_from() {
        let matrices = [(1, 0.2126, 0.0722), (6, 0.299, 0.114), (9, 0.2627, 0.0593)];
        let colours = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.9, 0.2, 0.1], [0.1, 0.8, 0.3], [0.2, 0.3, 0.9]];
        for (matrix, kr, kb) in matrices {
            for is_full_range in [false, true] {
                let mut conversion = YuvToRgb::new(4, 4, Colour { matrix, is_full_range }).unwrap();
                for colour in colours {
                    let [y, u, v] = reference(colour, kr, kb, is_full_range);
                    for has_half_rows in [true, false] {
                        let (y, u, v) = ([y; 16], [u; 8], [v; 8]);
                        let rgb = conversion.convert(&planes(&y, &u, &v, has_half_rows)).unwrap();
                        for (found, wanted) in rgb.at(3, 3).into_iter().zip(colour) {
                            // Rounding luma and chroma to 8 bit costs up to two levels.
                            let difference = f64::from(found) - 255.0 * wanted;
                            assert!(difference.abs() <= 2.0, "matrix {matrix}, {colour:?}: {rgb:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn chroma_is_linear_between_its_samples() {
        let (y, u, v) = ([128; 16], [128; 8], [128, 148, 128, 148, 0, 0, 0, 0]);
        let mut conversion = YuvToRgb::new(4, 4, Colour { matrix: 6, is_full_range: true }).unwrap();
        conversion.interpolate_chroma(&planes(&y, &u, &v, true), 1);
        assert_eq!(conversion.chroma_row.iter().map(|chroma| chroma[1]).collect::<Vec<_>>(), [0, 80, 160, 160]);
    }

    #[test]
    fn an_unknown_matrix_is_refused() {
        assert!(YuvToRgb::new(4, 4, Colour { matrix: 0, is_full_range: true }).is_none());
    }
}

//! The largest value of a field in a frame, plain and robust.
//!
//! Away from the camera's axis, a face that comes nearer also moves outwards in the image. The gel behind it is
//! stretched into a rim whose feature is larger than that of the face. The plain maximum is then that of the rim, the
//! robust maximum that of the face.

use fingervision_image::Image;
use serde::Serialize;

/// The value of a field that represents a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Maximum {
    /// The largest valid value, as published.
    #[default]
    Plain,
    /// The largest median over squares: the largest value that half of the pixels of a square reach, where invalid
    /// pixels count as not reaching it. The side of a square is a seventh of the image's shorter side, at least 9 px. A
    /// rim or an outlier narrower than half of a square has no effect; a face that fills half of a square keeps its
    /// value, even if its rims are not valid.
    Robust,
}

/// The image's shorter side over the side of the squares of [`Maximum::Robust`]. If a sensor sees 30 mm of gel, a
/// square is 4 mm wide. The stretched gel along the outer edges of a sliding face is 1 to 2 mm wide and fills less than
/// half of any square.
const WINDOW_PART: usize = 7;
/// Least side of a square, px: a little more than the ±2σ of the density's Gaussian, so that noise, which is correlated
/// over this length, cannot fill half of a square.
const LEAST_WINDOW: usize = 9;
/// Number of bisections of the interval that contains the robust maximum: to a millionth of the range.
const HALVINGS: usize = 20;

/// Finds the maximum of fields of one size; owns its scratch memory.
#[derive(Debug, Clone)]
pub struct MaximumFinder {
    kind: Maximum,
    /// Side of the square, px.
    window: usize,
    /// Number of pixels that reach a level, for each column of the window.
    columns: Vec<u32>,
}

impl MaximumFinder {
    /// A finder for fields of this many columns and rows, px.
    #[must_use]
    pub fn new(kind: Maximum, (width, height): (usize, usize)) -> Self {
        let window = (width.min(height) / WINDOW_PART).max(LEAST_WINDOW);
        Self { kind, window, columns: vec![0; width] }
    }

    /// The maximum where `valid` is 1; none if no pixel is valid, or if less than half of every window is valid.
    ///
    /// # Panics
    ///
    /// If the images differ in size.
    pub fn find(&mut self, values: &Image<f32>, valid: &Image<u8>) -> Option<f32> {
        assert_eq!(values.size(), valid.size(), "size of the validity");
        let pixels =
            || values.values().iter().zip(valid.values()).filter(|&(value, &valid)| valid == 1 && value.is_finite());
        let largest = pixels().map(|(&value, _)| value).reduce(f32::max)?;
        match self.kind {
            Maximum::Plain => Some(largest),
            Maximum::Robust => {
                let smallest = pixels().map(|(&value, _)| value).fold(largest, f32::min);
                self.largest_median(values, valid, smallest, largest)
            }
        }
    }

    /// Halves the interval until the largest level is found that half a window reaches.
    fn largest_median(&mut self, values: &Image<f32>, valid: &Image<u8>, mut low: f32, mut high: f32) -> Option<f32> {
        if values.width() < self.window || values.height() < self.window || !self.is_reached(values, valid, low) {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            *(if self.is_reached(values, valid, middle) { &mut low } else { &mut high }) = middle;
        }
        Some(low)
    }

    /// Whether half of any window is valid and at this level or above.
    fn is_reached(&mut self, values: &Image<f32>, valid: &Image<u8>, level: f32) -> bool {
        self.columns.fill(0);
        for y in 0..values.height() {
            self.add_row(values, valid, y, level, u32::wrapping_add);
            if y >= self.window {
                self.add_row(values, valid, y - self.window, level, u32::wrapping_sub);
            }
            if y + 1 >= self.window && self.has_full_window() {
                return true;
            }
        }
        false
    }

    fn add_row(&mut self, values: &Image<f32>, valid: &Image<u8>, y: usize, level: f32, add: fn(u32, u32) -> u32) {
        for (count, (&value, &valid)) in self.columns.iter_mut().zip(values.row(y).iter().zip(valid.row(y))) {
            *count = add(*count, u32::from(valid == 1 && value >= level));
        }
    }

    fn has_full_window(&self) -> bool {
        let whole = (self.window * self.window) as u32;
        self.columns.windows(self.window).any(|reached| 2 * reached.iter().sum::<u32>() > whole)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WINDOW: usize = LEAST_WINDOW;

    fn find(kind: Maximum, values: &Image<f32>, valid: &Image<u8>) -> Option<f32> {
        MaximumFinder::new(kind, values.size()).find(values, valid)
    }

    /// The definition, window by window.
    fn largest_median(values: &Image<f32>, valid: &Image<u8>) -> Option<f32> {
        let mut largest: Option<f32> = None;
        for top in 0..=values.height() - WINDOW {
            for left in 0..=values.width() - WINDOW {
                let pixels = || (0..WINDOW * WINDOW).map(|i| (left + i % WINDOW, top + i / WINDOW));
                let held = |(x, y)| if valid.at(x, y) == 1 { values.at(x, y) } else { f32::NEG_INFINITY };
                let mut sorted: Vec<f32> = pixels().map(held).collect();
                sorted.sort_by(f32::total_cmp);
                let median = sorted[sorted.len() / 2];
                if median.is_finite() {
                    largest = Some(largest.map_or(median, |largest| largest.max(median)));
                }
            }
        }
        largest
    }

    #[test]
    fn the_robust_maximum_is_the_largest_median() {
        let values =
            Image::from_fn(40, 25, |x, y| ((x * 7919 + y * 104_729 + x * y * 31) % 1009) as f32 / 1009.0 - 0.3);
        let valid = Image::from_fn(40, 25, |x, y| u8::from((x * 5 + 3 * y) % 7 > 1));
        let (found, expected) =
            (find(Maximum::Robust, &values, &valid).unwrap(), largest_median(&values, &valid).unwrap());
        assert!((found - expected).abs() < 2e-6, "{found}, expected {expected}");
    }

    #[test]
    fn a_thin_rim_moves_the_plain_maximum_alone() {
        let face = |x: usize, y: usize| (10..30).contains(&x) && (10..30).contains(&y);
        let values = Image::from_fn(60, 60, |x, y| if x == 40 { 5.0 } else { f32::from(u8::from(face(x, y))) });
        let valid = Image::filled(60, 60, 1);
        assert_eq!(find(Maximum::Plain, &values, &valid), Some(5.0));
        let robust = find(Maximum::Robust, &values, &valid).unwrap();
        assert!((robust - 1.0).abs() < 1e-5, "{robust}");
    }

    #[test]
    fn what_is_not_valid_does_not_count() {
        let values = Image::from_fn(20, 20, |x, _| x as f32);
        let left = Image::from_fn(20, 20, |x, _| u8::from(x < 12));
        assert_eq!(find(Maximum::Plain, &values, &left), Some(11.0));
        assert!((find(Maximum::Robust, &values, &left).unwrap() - 7.0).abs() < 1e-4);
        let nothing = Image::filled(20, 20, 0);
        assert_eq!([Maximum::Plain, Maximum::Robust].map(|kind| find(kind, &values, &nothing)), [None, None]);
    }
}

//! The image pyramid: every level has half the columns and rows of the one before.
//!
//! Level 0 is the full size. A pixel of level `l + 1` is the mean of the 2×2 pixels of level `l` that it covers, so a
//! point at `x` on level `l` lies at `(x + ½)/2 − ½` on level `l + 1`. An odd last column or row is left out.

use crate::Image;

/// Grey levels at full size and at every halving down to the coarsest.
#[derive(Debug, Clone, PartialEq)]
pub struct Pyramid {
    levels: Vec<Image<f32>>,
}

impl Pyramid {
    /// An empty pyramid over an image of this size, with levels 0 to `coarsest_level`.
    #[must_use]
    pub fn new(width: usize, height: usize, coarsest_level: usize) -> Self {
        let levels = (0..=coarsest_level).map(|level| Image::filled(width >> level, height >> level, 0.0));
        Self { levels: levels.collect() }
    }

    /// Number of levels, the full size included.
    #[must_use]
    pub fn levels(&self) -> usize {
        self.levels.len()
    }

    /// The image at a level.
    ///
    /// # Panics
    ///
    /// If the pyramid ends before that level.
    #[must_use]
    pub fn level(&self, level: usize) -> &Image<f32> {
        &self.levels[level]
    }

    /// The image at the coarsest level.
    #[must_use]
    pub fn coarsest(&self) -> &Image<f32> {
        &self.levels[self.levels.len() - 1]
    }

    /// The full-size image, to be written before [`Pyramid::build`].
    pub fn base_mut(&mut self) -> &mut Image<f32> {
        &mut self.levels[0]
    }

    /// Takes the levels of `other`, without allocating where the sizes agree.
    pub fn copy_from(&mut self, other: &Self) {
        self.levels.resize_with(other.levels.len(), || Image::filled(0, 0, 0.0));
        for (level, other) in self.levels.iter_mut().zip(&other.levels) {
            level.copy_from(other);
        }
    }

    /// Fills every level above the full size from the one below it.
    pub fn build(&mut self) {
        for level in 1..self.levels.len() {
            let (fine, coarse) = self.levels.split_at_mut(level);
            halve_into(&fine[level - 1], &mut coarse[0]);
        }
    }
}

/// Writes the means of all whole 2×2 blocks of `fine` into `coarse`.
///
/// # Panics
///
/// If `coarse` is not half as wide and high, rounded down.
pub fn halve_into(fine: &Image<f32>, coarse: &mut Image<f32>) {
    assert_eq!(coarse.size(), (fine.width() / 2, fine.height() / 2), "size of the coarser level");
    for (y, coarse) in coarse.rows_mut().enumerate() {
        let (above, below) = (fine.row(2 * y), fine.row(2 * y + 1));
        let blocks = above.chunks_exact(2).zip(below.chunks_exact(2));
        for (coarse, (above, below)) in coarse.iter_mut().zip(blocks) {
            *coarse = 0.25 * (above[0] + above[1] + below[0] + below[1]);
        }
    }
}

/// Writes the mean of `fine` over the area of every pixel of `coarse`, whatever the two sizes.
pub fn average_into(fine: &Image<f32>, coarse: &mut Image<f32>) {
    let (width, height) = coarse.size();
    let step_x = fine.width() as f32 / width as f32;
    let step_y = fine.height() as f32 / height as f32;
    for (y, row) in coarse.rows_mut().enumerate() {
        let (top, bottom) = (y as f32 * step_y, (y + 1) as f32 * step_y);
        for (x, value) in row.iter_mut().enumerate() {
            let (left, right) = (x as f32 * step_x, (x + 1) as f32 * step_x);
            let mut sum = 0.0;
            for (row, weight_y) in covered(top, bottom, fine.height()) {
                for (column, weight_x) in covered(left, right, fine.width()) {
                    sum += weight_x * weight_y * fine.at(column, row);
                }
            }
            *value = sum / (step_x * step_y);
        }
    }
}

/// The pixels that `[start, end)` covers, each with the covered part of it.
fn covered(start: f32, end: f32, size: usize) -> impl Iterator<Item = (usize, f32)> {
    let last = (end.ceil() as usize).min(size);
    (start as usize..last).map(move |pixel| {
        let (low, high) = (pixel as f32, (pixel + 1) as f32);
        (pixel, high.min(end) - low.max(start))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_stays_a_ramp_at_pixel_centres() {
        let mut pyramid = Pyramid::new(13, 9, 2);
        *pyramid.base_mut() = Image::from_fn(13, 9, |x, y| x as f32 + 100.0 * y as f32);
        pyramid.build();
        assert_eq!(pyramid.level(2).size(), (3, 2));
        // Pixel (1, 1) of level 2 covers columns and rows 4 to 7: its centre is 5.5.
        assert!((pyramid.level(2).at(1, 1) - (5.5 + 550.0)).abs() < 1e-3);
    }

    #[test]
    fn averaging_keeps_the_mean_for_any_size() {
        let fine = Image::from_fn(61, 45, |x, y| ((x * 7 + y * 13) % 29) as f32);
        let mean = |image: &Image<f32>| image.values().iter().sum::<f32>() / image.values().len() as f32;
        for (width, height) in [(61, 45), (20, 15), (7, 9)] {
            let mut coarse = Image::filled(width, height, 0.0);
            average_into(&fine, &mut coarse);
            assert!((mean(&coarse) - mean(&fine)).abs() < 1e-3, "{width}x{height}: {}", mean(&coarse));
        }
    }
}

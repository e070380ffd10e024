//! Computes rows of pixels from rows of parts: the optics' blur and the pixel's area.

use crate::blur::{Blur, SUB_PIXELS};
use fearless_simd::{Simd, f32x4, f32x16, prelude::*};
use fearless_simd_macros::simd;

/// Channels of a part, one of them unused.
const CHANNELS: usize = 4;

/// Values that a kernel processes together.
const LANES: usize = 16;

/// The rows of parts for a row of pixels, in a ring buffer.
#[derive(Debug, Clone)]
pub(crate) struct Sensor {
    weights: Vec<f32>,
    parts: usize,
    rows: Vec<Vec<[f32; CHANNELS]>>,
    /// The weighted sum of the rows.
    sum: Vec<[f32; CHANNELS]>,
}

impl Sensor {
    /// A sensor for rows of `parts` parts.
    pub(crate) fn new(blur: &Blur, parts: usize) -> Self {
        let weights = blur.weights().to_vec();
        let padded = parts.next_multiple_of(LANES / CHANNELS);
        let row = vec![[0.0; CHANNELS]; padded];
        Self { rows: vec![row.clone(); weights.len()], weights, parts, sum: row }
    }

    /// The buffer for a row of parts.
    pub(crate) fn row_mut(&mut self, row: usize) -> &mut [[f32; CHANNELS]] {
        let index = row % self.rows.len();
        &mut self.rows[index][..self.parts]
    }

    /// The row of pixels, if any, that the row of parts just written completes.
    pub(crate) fn completed(&self, row: usize) -> Option<usize> {
        let first = (row + 1).checked_sub(self.weights.len())?;
        first.is_multiple_of(SUB_PIXELS).then_some(first / SUB_PIXELS)
    }

    /// Passes each pixel of a completed row on: column; red, green, blue and nothing.
    #[simd]
    pub(crate) fn expose<S: Simd>(&mut self, simd: S, pixel_row: usize, mut take: impl FnMut(usize, [f32; CHANNELS])) {
        self.add_rows(simd, pixel_row * SUB_PIXELS);
        let pixels = (self.parts + SUB_PIXELS - self.weights.len()) / SUB_PIXELS;
        for pixel in 0..pixels {
            let mut total = f32x4::splat(simd, 0.0);
            for (part, &weight) in self.sum[SUB_PIXELS * pixel..].iter().zip(&self.weights) {
                total = f32x4::load_array(simd, *part).mul_add(weight, total);
            }
            take(pixel, total.to_array());
        }
    }

    #[inline(always)]
    fn add_rows<S: Simd>(&mut self, simd: S, first: usize) {
        let Self { weights, rows, sum, .. } = self;
        for (block, sum) in sum.as_flattened_mut().as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
            let mut total = f32x16::splat(simd, 0.0);
            for (k, &weight) in weights.iter().enumerate() {
                let row = rows[(first + k) % rows.len()].as_flattened();
                total = f32x16::from_slice(simd, &row[block * LANES..][..LANES]).mul_add(weight, total);
            }
            total.store_array(sum);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};
    use fingervision_image::Image;

    #[test]
    fn rows_in_turn_are_blurred_as_the_whole_image_is() {
        for sigma_px in [0.0, 0.7, 1.3] {
            let blur = Blur::new(sigma_px);
            let size = [9, 7].map(|pixels| pixels * SUB_PIXELS + 2 * blur.margin());
            let part = |x: usize, y: usize| [(7 * x + 13 * y) % 17, (5 * x * y) % 11, x + y].map(|value| value as f32);
            let expected = blur.apply(&Image::from_fn(size[0], size[1], part));
            let mut sensor = Sensor::new(&blur, size[0]);
            let mut completed = 0;
            for row in 0..size[1] {
                for (x, value) in sensor.row_mut(row).iter_mut().enumerate() {
                    let [red, green, blue] = part(x, row);
                    *value = [red, green, blue, 0.0];
                }
                let Some(pixel_row) = sensor.completed(row) else { continue };
                assert_eq!(pixel_row, completed);
                completed += 1;
                dispatch!(Level::new(), simd => sensor.expose(simd, pixel_row, |x, pixel| {
                    let expected = expected.at(x, pixel_row);
                    let misses = (0..3).map(|channel| (pixel[channel] - expected[channel]).abs());
                    assert!(misses.fold(0.0, f32::max) < 1e-4, "({x}, {pixel_row}): {pixel:?}, {expected:?}");
                }));
            }
            assert_eq!(completed, 7);
        }
    }
}

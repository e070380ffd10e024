//! Weighted sums over every patch's window.
//!
//! The window is separable. So the rows are summed first, for all columns at once, then the columns of each patch.

use super::grid::{LANES, STRIDE, WINDOW, offset, window_weights};
use fearless_simd::{Simd, f32x16, prelude::*};
use fearless_simd_macros::simd;

/// The rows of one quantity that a row of patches covers: the upper and the lower half. Only every `step`-th row is
/// used.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Band<'a> {
    pub(crate) halves: [&'a [f32]; 2],
    pub(crate) step: usize,
}

/// Window weights times powers of the distance from the centre in strides: `w`, `w·ξ`, `w·ξ²`.
#[derive(Debug, Clone)]
pub(crate) struct Window {
    powers: [[f32; WINDOW]; 3],
    /// Sum of the weights over a whole window, px.
    pub(crate) area: f32,
}

impl Window {
    pub(crate) fn new() -> Self {
        let weights = window_weights();
        let power = |p: i32| std::array::from_fn(|k| weights[k] * offset(k).powi(p));
        Self { powers: [power(0), power(1), power(2)], area: weights.iter().sum::<f32>().powi(2) }
    }

    /// Sum of the weights of all patches at a pixel, on average, dimensionless.
    pub(crate) fn overlap(&self) -> f32 {
        self.area / (STRIDE * STRIDE) as f32
    }
}

/// Writes `Σ w(η) η^power · band` over the rows that are used, for every padded column.
#[simd]
pub(crate) fn sum_rows<S: Simd>(simd: S, window: &Window, power: usize, band: Band<'_>, sums: &mut [f32]) {
    let width = sums.len();
    for (block, sums) in sums.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
        let mut total = f32x16::splat(simd, 0.0);
        for (half, rows) in band.halves.into_iter().enumerate() {
            for row in (0..STRIDE).step_by(band.step) {
                let values = f32x16::from_slice(simd, &rows[row * width + block * LANES..][..LANES]);
                total = values.mul_add(window.powers[power][half * STRIDE + row], total);
            }
        }
        total.store_array(sums);
    }
}

/// Writes `Σ w(η) · band` and `Σ w(η) η · band` over the rows that are used, for every padded column.
#[simd]
pub(crate) fn sum_rows_twice<S: Simd>(simd: S, window: &Window, band: Band<'_>, sums: [&mut [f32]; 2]) {
    let [plain, first] = sums;
    let width = plain.len();
    let blocks = plain.as_chunks_mut::<LANES>().0.iter_mut().zip(first.as_chunks_mut::<LANES>().0);
    for (block, (plain, first)) in blocks.enumerate() {
        let mut totals = [f32x16::splat(simd, 0.0); 2];
        for (half, rows) in band.halves.into_iter().enumerate() {
            for row in (0..STRIDE).step_by(band.step) {
                let values = f32x16::from_slice(simd, &rows[row * width + block * LANES..][..LANES]);
                let k = half * STRIDE + row;
                totals[0] = values.mul_add(window.powers[0][k], totals[0]);
                totals[1] = values.mul_add(window.powers[1][k], totals[1]);
            }
        }
        totals[0].store_array(plain);
        totals[1].store_array(first);
    }
}

/// Writes `Σ w(ξ) ξ^power · sums` over every patch's columns.
#[simd]
pub(crate) fn sum_columns<S: Simd>(simd: S, window: &Window, power: usize, sums: &[f32], moments: &mut [f32]) {
    let weights = f32x16::load_array(simd, window.powers[power]);
    for (patch, moment) in moments.iter_mut().enumerate() {
        let values = f32x16::from_slice(simd, &sums[STRIDE * patch..][..WINDOW]);
        *moment = (values * weights).reduce_sum();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    #[test]
    fn moments_equal_their_definition() {
        let (columns, width) = (3, 32);
        let value = |x: usize, y: usize| ((7 * x + 13 * y) % 17) as f32 - 5.0;
        let rows: Vec<f32> = (0..WINDOW).flat_map(|y| (0..width).map(move |x| value(x, y))).collect();
        let (upper, lower) = rows.split_at(STRIDE * width);
        let window = Window::new();
        let weights = window_weights();
        for (power_x, power_y, step) in [(0, 0, 1), (1, 0, 1), (0, 1, 2), (1, 1, 4), (2, 0, 2)] {
            let band = Band { halves: [upper, lower], step };
            let (mut sums, mut moments) = (vec![0.0; width], vec![0.0; columns]);
            dispatch!(Level::new(), simd => sum_rows(simd, &window, power_y, band, &mut sums));
            dispatch!(Level::new(), simd => sum_columns(simd, &window, power_x, &sums, &mut moments));
            for (patch, moment) in moments.iter().enumerate() {
                let mut expected = 0.0;
                for y in (0..WINDOW).step_by(step) {
                    for x in 0..WINDOW {
                        let power = f64::from(offset(x)).powf(f64::from(power_x as u8))
                            * f64::from(offset(y)).powf(f64::from(power_y as u8));
                        expected += f64::from(weights[x] * weights[y] * value(STRIDE * patch + x, y)) * power;
                    }
                }
                assert!(
                    (f64::from(*moment) - expected).abs() < 1e-2,
                    "{power_x} {power_y}: {moment} against {expected}"
                );
            }
        }
    }
}

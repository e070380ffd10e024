//! Smoothing on the pixel grid: the part of the Gaussian that the splines do not contribute.

use std::f64::consts::PI;

use fearless_simd::{f32x16, prelude::*};
use fearless_simd_macros::simd;

/// Taps on each side that are processed together.
const STEP: usize = 4;
/// Nodes that are processed together.
const LANES: usize = 16;

/// The taps of a symmetric kernel, from its centre outwards, that turns two cubic B-splines into a Gaussian.
///
/// A cubic B-spline of the pixel grid has the spectrum `sinc⁴(k/2)`. The taps are the inverse transform of
/// `exp(−σ²k²/2) / sinc⁸(k/2)`: spread by a spline, smoothed by the taps and read by a spline, a point becomes a
/// Gaussian of standard deviation σ px. To second order in `k` this is a Gaussian of variance `σ² − 2/3`. The taps end
/// at 4σ and sum to 1.
pub(super) fn taps(sigma: f64) -> Vec<f32> {
    const SAMPLES: usize = 256;
    let spectrum = |k: f64| {
        let sinc = if k > 0.0 { (0.5 * k).sin() / (0.5 * k) } else { 1.0 };
        (-0.5 * (sigma * k).powi(2)).exp() / sinc.powi(8)
    };
    // The midpoint rule is exact except for aliases 2·SAMPLES px away, where the kernel has vanished.
    let tap = |n: usize| {
        let waves = (0..SAMPLES).map(|i| (i as f64 + 0.5) * PI / SAMPLES as f64);
        waves.map(|k| spectrum(k) * (k * n as f64).cos()).sum::<f64>()
    };
    let taps: Vec<f64> = (0..=reach(sigma)).map(tap).collect();
    let sum = taps[0] + 2.0 * taps[1..].iter().sum::<f64>();
    taps.iter().map(|tap| (tap / sum) as f32).collect()
}

/// Reach of the taps for this σ from their centre, px. A multiple of four, because they are processed in fours.
pub(super) fn reach(sigma: f64) -> usize {
    4 * sigma.ceil() as usize
}

/// Smooths `from` by `taps` along columns and rows into `to`, leaving a border of `border` px unchanged.
///
/// Both are row-major with `stride` columns; `down` is scratch of one row. The taps reach no farther than `border`.
#[simd]
pub(super) fn smooth<S: Simd>(
    simd: S,
    taps: &[f32],
    (stride, border): (usize, usize),
    from: &[f32],
    to: &mut [f32],
    down: &mut [f32],
) {
    let (reach, inner) = (taps.len() - 1, stride - 2 * border);
    for y in border..from.len() / stride - border {
        weigh(simd, taps, |n| &from[(y + n - reach) * stride..][..stride], down);
        weigh(simd, taps, |n| &down[border + n - reach..][..inner], &mut to[y * stride + border..][..inner]);
    }
}

/// `to = Σ taps[|n|] · at(reach + n)`, both sides of the kernel in one multiplication.
#[simd]
fn weigh<'a, S: Simd>(simd: S, taps: &[f32], at: impl Fn(usize) -> &'a [f32], to: &mut [f32]) {
    let reach = taps.len() - 1;
    let centre = (taps[0], at(reach));
    for first in (1..reach).step_by(STEP) {
        let sides = std::array::from_fn(|k| [at(reach - first - k), at(reach + first + k)]);
        let factors = std::array::from_fn(|k| taps[first + k]);
        add_taps(simd, to, if first == 1 { Some(centre) } else { None }, factors, sides);
    }
}

/// Adds `Σ taps[k] · (sides[k][0] + sides[k][1])` to the product of a tap and the `centre`, or without a centre to `to`.
#[simd]
fn add_taps<S: Simd>(
    simd: S,
    to: &mut [f32],
    centre: Option<(f32, &[f32])>,
    taps: [f32; STEP],
    sides: [[&[f32]; 2]; STEP],
) {
    let width = to.len();
    let sides = sides.map(|[before, behind]| [&before[..width], &behind[..width]]);
    let (chunks, rest) = to.as_chunks_mut::<LANES>();
    for (chunk, to) in chunks.iter_mut().enumerate() {
        let at = chunk * LANES;
        let mut sum = match centre {
            Some((tap, centre)) => f32x16::from_slice(simd, &centre[at..][..LANES]) * tap,
            None => f32x16::from_slice(simd, to),
        };
        for k in 0..STEP {
            let before = f32x16::from_slice(simd, &sides[k][0][at..][..LANES]);
            let behind = f32x16::from_slice(simd, &sides[k][1][at..][..LANES]);
            sum = (before + behind).mul_add(taps[k], sum);
        }
        sum.store_slice(to);
    }
    let first = width - rest.len();
    for (at, to) in (first..).zip(rest) {
        let mut sum = centre.map_or(*to, |(tap, centre)| centre[at] * tap);
        for k in 0..STEP {
            sum += (sides[k][0][at] + sides[k][1][at]) * taps[k];
        }
        *to = sum;
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};

    use super::*;

    #[test]
    fn the_taps_have_the_variance_that_splines_leave() {
        for sigma in [1.5, 2.0, 3.0, 8.0] {
            let taps = taps(sigma);
            let moment = |power: i32| {
                let side = taps.iter().enumerate().skip(1).map(|(n, &tap)| f64::from(tap) * (n as f64).powi(power));
                2.0 * side.sum::<f64>()
            };
            let (sum, variance) = (f64::from(taps[0]) + moment(0), moment(2));
            assert!((sum - 1.0).abs() < 1e-6, "sigma {sigma}: sum {sum}");
            assert!((variance - (sigma * sigma - 2.0 / 3.0)).abs() < 1e-3 * variance, "sigma {sigma}: {variance}");
        }
    }

    #[test]
    fn smoothing_is_the_sum_over_taps() {
        let (taps, stride, rows, border) = ([0.5f32, 0.2, -0.1, 0.07, 0.03], 23, 19, 5);
        let from: Vec<f32> = (0..stride * rows).map(|i| ((i * i) as f32 * 0.37).sin()).collect();
        let (mut to, mut down) = (vec![7.0; from.len()], vec![0.0; stride]);
        dispatch!(Level::new(), simd => smooth(simd, &taps, (stride, border), &from, &mut to, &mut down));
        for (i, &value) in to.iter().enumerate() {
            let (x, y) = (i % stride, i / stride);
            let is_inner = (border..stride - border).contains(&x) && (border..rows - border).contains(&y);
            let window = (0..81).map(|k| (x + k % 9, y + k / 9, taps[(k % 9).abs_diff(4)], taps[(k / 9).abs_diff(4)]));
            let sum =
                |(x, y, a, b): (usize, usize, f32, f32)| f64::from(from[(y - 4) * stride + x - 4] * a) * f64::from(b);
            let expected = if is_inner { window.map(sum).sum::<f64>() } else { 7.0 };
            assert!((f64::from(value) - expected).abs() < 1e-6, "({x}, {y}): {value}, not {expected}");
        }
    }
}

//! The current picture at points between its pixels, by cubic B-splines on 4×4 px, sixteen points at a time.
//!
//! Where neighbours in a row move together, the pixels that they need are neighbours, too: their taps are then read as whole
//! registers. Otherwise every point reads its own.

use super::grid::LANES;
use fearless_simd::{Simd, f32x4, f32x16, mask32x16, prelude::*};
use fingervision_image::Image;

/// Largest distance of a point from the part of the picture that has all taps, px, at which it still counts as inside.
const BORDER_PX: f32 = 1.0 / 64.0;
/// Pixels along each axis of which neighbours use four each: their motions differ by less than two pixels.
const SHARED: usize = 5;

/// The size of a picture as the kernels need it: computed once for many points.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds {
    /// Values in a row.
    stride: f32,
    /// Number of pixels.
    count: f32,
    /// The largest column and row of a point that has all taps.
    largest: [f32; 2],
}

impl Bounds {
    /// Of a picture with these columns and rows.
    pub(crate) fn of((width, height): (usize, usize)) -> Self {
        let largest = [width, height].map(|size| size as f32 - 2.0 - BORDER_PX);
        Self { stride: width as f32, count: (width * height) as f32, largest }
    }
}

/// The taps of sixteen neighbours in a row of which most are the same.
pub(crate) struct SharedTaps<S: Simd> {
    /// Index of the first point's upper left pixel.
    start: usize,
    weights_x: [f32x16<S>; SHARED],
    weights_y: [f32x16<S>; SHARED],
}

/// The taps of any sixteen points.
pub(crate) struct SingleTaps<S: Simd> {
    /// Index of every point's upper left pixel.
    base: [u32; LANES],
    weights_x: [f32x16<S>; 4],
    weights_y: [f32x16<S>; 4],
}

/// Sixteen points relative to the pixels of a picture.
pub(crate) struct Places<S: Simd> {
    /// The pixel to the upper left of each point: column and row.
    corner: [f32x16<S>; 2],
    /// Distance of each point from there.
    fraction: [f32x16<S>; 2],
    /// Whether the point and its taps lie in the picture. The places of other points are moved into it.
    inside: mask32x16<S>,
}

impl<S: Simd> Places<S> {
    /// The points at `x` and `y` in a picture.
    #[inline(always)]
    pub(crate) fn of(x: f32x16<S>, y: f32x16<S>, Bounds { largest, .. }: Bounds) -> Self {
        // NaN is clamped to the lower bound. Its distance from there is NaN, so it counts as outside.
        let clamped = [x.max_precise(1.0).min(largest[0]), y.max_precise(1.0).min(largest[1])];
        let corner = clamped.map(SimdFloat::floor);
        let near = |place: f32x16<S>, clamped: f32x16<S>| (place - clamped).abs().simd_le(BORDER_PX);
        let inside = near(x, clamped[0]) & near(y, clamped[1]);
        Self { corner, fraction: [clamped[0] - corner[0], clamped[1] - corner[1]], inside }
    }

    /// 1 for every point that lies in the picture with its taps, else 0.
    #[inline(always)]
    pub(crate) fn inside(&self, simd: S) -> f32x16<S> {
        self.inside.select(f32x16::splat(simd, 1.0), f32x16::splat(simd, 0.0))
    }

    /// The taps of every point.
    #[inline(always)]
    pub(crate) fn single(&self, Bounds { stride, .. }: Bounds) -> SingleTaps<S> {
        let [left, top] = self.corner;
        let base = (top - 1.0) * stride + (left - 1.0);
        SingleTaps {
            base: base.to_int::<fearless_simd::u32x16<S>>().to_array(),
            weights_x: spline_weights(self.fraction[0]),
            weights_y: spline_weights(self.fraction[1]),
        }
    }

    /// The taps of neighbours in a row, if they moved alike, but for one column and one row.
    #[inline(always)]
    pub(crate) fn shared(&self, simd: S, Bounds { stride, count, .. }: Bounds) -> Option<SharedTaps<S>> {
        const FAR: f32 = 1e9;
        let lanes = std::array::from_fn(|lane| lane as f32);
        let motion = [self.corner[0] - f32x16::load_array(simd, lanes), self.corner[1]];
        let far = f32x16::splat(simd, FAR);
        let first = motion.map(|motion| self.inside.select(motion, far).reduce_min());
        let shift = [motion[0] - first[0], motion[1] - first[1]];
        let is_shared = shift[0].simd_le(1.0) & shift[1].simd_le(1.0) | !self.inside;
        let [left, top] = first;
        if !is_shared.all_true() || left >= FAR {
            return None;
        }
        // Exact: the number of pixels is limited.
        let start = (top - 1.0) * stride + (left - 1.0);
        let end = start + (SHARED - 1) as f32 * stride + (LANES + SHARED - 1) as f32;
        if start < 0.0 || end > count {
            return None;
        }
        let [weights_x, weights_y] = [0, 1].map(|axis| {
            let is_shifted = shift[axis].simd_ge(1.0);
            let [a, b, c, d] = spline_weights(self.fraction[axis]);
            let zero = f32x16::splat(simd, 0.0);
            let either = |shifted, own| is_shifted.select(shifted, own);
            [either(zero, a), either(a, b), either(b, c), either(c, d), either(d, zero)]
        });
        Some(SharedTaps { start: start as u32 as usize, weights_x, weights_y })
    }
}

impl<S: Simd> SharedTaps<S> {
    /// The picture at the points.
    #[inline(always)]
    pub(crate) fn sample(&self, simd: S, picture: &Image<f32>) -> f32x16<S> {
        let (stride, values) = (picture.width(), &picture.values()[self.start..]);
        let rows: [&[f32]; SHARED] = std::array::from_fn(|row| &values[row * stride..][..LANES + SHARED - 1]);
        let [a, b, c, d, e] = self.weights_y;
        let mut sum = f32x16::splat(simd, 0.0);
        for (column, &weight) in self.weights_x.iter().enumerate() {
            let load = |row: usize| f32x16::from_slice(simd, &rows[row][column..column + LANES]);
            let down = load(0) * a;
            let down = load(1).mul_add(b, down);
            let down = load(2).mul_add(c, down);
            let down = load(3).mul_add(d, down);
            sum = load(4).mul_add(e, down).mul_add(weight, sum);
        }
        sum
    }
}

impl<S: Simd> SingleTaps<S> {
    /// The picture at the points.
    #[inline(always)]
    pub(crate) fn sample(&self, simd: S, picture: &Image<f32>) -> f32x16<S> {
        let Self { base, weights_x, weights_y } = self;
        let (stride, values) = (picture.width(), picture.values());
        let weights_y: [[f32; LANES]; 4] = weights_y.map(SimdBase::to_array);
        let mut columns = [[0.0f32; 4]; LANES];
        for (k, columns) in columns.iter_mut().enumerate() {
            let rows = &values[base[k] as usize..][..3 * stride + 4];
            let row = |j: usize| f32x4::from_slice(simd, &rows[j * stride..][..4]);
            let sum = row(0) * weights_y[0][k];
            let sum = row(1).mul_add(weights_y[1][k], sum);
            let sum = row(2).mul_add(weights_y[2][k], sum);
            *columns = row(3).mul_add(weights_y[3][k], sum).to_array();
        }
        let [column_0, column_1, column_2, column_3] = transpose(simd, &columns);
        let sum = column_0 * weights_x[0];
        let sum = column_1.mul_add(weights_x[1], sum);
        let sum = column_2.mul_add(weights_x[2], sum);
        column_3.mul_add(weights_x[3], sum)
    }
}

/// Cubic B-spline weights of the taps at −1, 0, 1 and 2 for a fraction `t`.
#[inline(always)]
fn spline_weights<S: Simd>(t: f32x16<S>) -> [f32x16<S>; 4] {
    let (s, t_square) = (1.0 - t, t * t);
    let first = s * s * (s * (1.0 / 6.0));
    let last = t_square * (t * (1.0 / 6.0));
    let second = t.mul_add(0.5, -1.0).mul_add(t_square, 2.0 / 3.0);
    // The sum of all is 1.
    [first, second, 1.0 - second - (first + last), last]
}

/// Sixteen quadruples as four registers, one of all their first values, one of all their second, and so on.
#[inline(always)]
fn transpose<S: Simd>(simd: S, quadruples: &[[f32; 4]; LANES]) -> [f32x16<S>; 4] {
    let values = quadruples.as_flattened();
    let load = |k: usize| f32x16::from_slice(simd, &values[LANES * k..][..LANES]);
    let (even_low, odd_low) = load(0).deinterleave(load(1));
    let (even_high, odd_high) = load(2).deinterleave(load(3));
    let (first, third) = even_low.deinterleave(even_high);
    let (second, fourth) = odd_low.deinterleave(odd_high);
    [first, second, third, fourth]
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    const SIZE: (usize, usize) = (40, 12);

    fn picture() -> Image<f32> {
        Image::from_fn(SIZE.0, SIZE.1, |x, y| ((37 * x + 101 * y + 5 * x * y) % 251) as f32)
    }

    /// By its definition, in double precision.
    fn expected(picture: &Image<f32>, x: f64, y: f64) -> f64 {
        let spline = |distance: f64| match distance.abs() {
            d if d < 1.0 => 2.0 / 3.0 - d * d + 0.5 * d * d * d,
            d if d < 2.0 => (2.0 - d).powi(3) / 6.0,
            _ => 0.0,
        };
        let pixels = (0..SIZE.1).flat_map(|row| (0..SIZE.0).map(move |column| (column, row)));
        pixels
            .map(|(column, row)| {
                spline(x - column as f64) * spline(y - row as f64) * f64::from(picture.at(column, row))
            })
            .sum()
    }

    /// Samples neighbours from a column on, displaced by `motion`; returns whether their taps were shared.
    fn check(row: f32, first: f32, motion: impl Fn(usize) -> [f32; 2]) -> bool {
        let picture = picture();
        let x: [f32; LANES] = std::array::from_fn(|k| first + k as f32 + motion(k)[0]);
        let y: [f32; LANES] = std::array::from_fn(|k| row + motion(k)[1]);
        dispatch!(Level::new(), simd => {
            let load = |values: [f32; LANES]| f32x16::load_array(simd, values);
            let bounds = Bounds::of(SIZE);
            let places = Places::of(load(x), load(y), bounds);
            let inside = places.inside(simd).to_array();
            let shared = places.shared(simd, bounds).map(|taps| taps.sample(simd, &picture).to_array());
            let single = places.single(bounds).sample(simd, &picture).to_array();
            for k in 0..LANES {
                let is_inside = (1.0..=SIZE.0 as f32 - 2.0).contains(&x[k]) && (1.0..=SIZE.1 as f32 - 2.0).contains(&y[k]);
                assert_eq!(inside[k] > 0.5, is_inside, "at {} {}", x[k], y[k]);
                if is_inside {
                    let expected = expected(&picture, f64::from(x[k]), f64::from(y[k]));
                    for found in [shared.unwrap_or(single)[k], single[k]] {
                        assert!((f64::from(found) - expected).abs() < 1e-2, "{found} for {expected}");
                    }
                }
            }
            shared.is_some()
        })
    }

    #[test]
    fn neighbours_that_move_alike_share_their_taps() {
        // A small motion to both sides of a pixel, as at rest.
        assert!(check(5.0, 9.0, |k| if k % 3 == 0 { [0.003, -0.002] } else { [-0.004, 0.001] }));
        assert!(check(5.0, 9.0, |k| [3.7 + 0.05 * k as f32, -2.2 + 0.04 * k as f32]));
        assert!(check(5.0, 9.0, |_| [-6.25, 2.5]));
    }

    #[test]
    fn neighbours_that_part_do_not() {
        assert!(!check(5.0, 9.0, |k| [0.2 * k as f32, 0.0]));
        assert!(!check(4.0, 9.0, |k| [0.0, 0.3 * k as f32]));
    }

    #[test]
    fn points_beyond_the_border_are_outside_and_those_beside_them_are_right() {
        assert!(check(5.0, -4.0, |_| [0.25, 0.25]));
        assert!(check(5.0, 30.0, |_| [0.25, 0.25]));
        // No pixel before the first row, none after the last one.
        assert!(!check(1.0, -4.0, |_| [0.25, 0.25]));
        assert!(!check(8.0, 9.0, |_| [0.25, 1.25]));
        assert!(!check(-9.0, 9.0, |_| [0.0, 0.0]));
        check(5.0, 9.0, |k| if k == 3 { [f32::NAN, 0.0] } else { [0.5, 0.5] });
    }
}

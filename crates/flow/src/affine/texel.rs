//! The value of one pixel in the kernels: a grey level, or red, green, blue and a zero.
//!
//! Both kinds sample the current image with cubic B-splines on 4×4 px and multiply the residual with the template's
//! gradient, sixteen pixels at a time.

use super::grid::LANES;
use super::places::{Places, SHARED, SharedTaps, Taps};
use fearless_simd::{Simd, f32x4, f32x16, prelude::*};
use fingervision_image::Image;

/// Sixteen pixels of one channel of the template.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TemplateBlock<'a> {
    pub(crate) values: &'a [f32],
    pub(crate) gradient_x: &'a [f32],
    pub(crate) gradient_y: &'a [f32],
}

/// Sums over the channels of products with the residual `r = T − g I(x + u)`, sixteen pixels of each.
pub(crate) struct Products<S: Simd> {
    /// `Σ r ∂T/∂x` and `Σ r ∂T/∂y`.
    pub(crate) gradient: [f32x16<S>; 2],
    /// `Σ r (T − MID_LEVEL)` and `Σ r`: the part explained by a change of light.
    pub(crate) light: [f32x16<S>; 2],
    /// `Σ r²`.
    pub(crate) energy: f32x16<S>,
}

/// Grey level subtracted from template values, so that gain and offset decouple.
pub(crate) const MID_LEVEL: f32 = 128.0;

/// A pixel type for the affine kernels.
pub(crate) trait Texel: Copy + Default + Send + Sync + 'static {
    /// Channels that carry a signal.
    const CHANNELS: usize;

    /// The texel as channels, unused ones zero.
    fn channels(self) -> [f32; 4];

    /// Sixteen samples of the current image: one register for each channel, the unused ones zero or repeated.
    fn sample<S: Simd>(simd: S, current: &Image<Self>, places: &Places<S>) -> [f32x16<S>; 3];
}

/// The products of sixteen pixels. `block` gives the template's channels, `gain` scales the current image.
#[inline(always)]
pub(crate) fn products<'a, S: Simd, T: Texel>(
    simd: S,
    current: &Image<T>,
    gain: f32,
    places: &Places<S>,
    block: impl Fn(usize) -> TemplateBlock<'a>,
) -> Products<S> {
    let samples = T::sample(simd, current, places);
    let zero = f32x16::splat(simd, 0.0);
    let mut sums = Products { gradient: [zero; 2], light: [zero; 2], energy: zero };
    for (channel, sample) in samples.into_iter().enumerate().take(T::CHANNELS) {
        let block = block(channel);
        let values = f32x16::from_slice(simd, block.values);
        let residual = values - sample * gain;
        let [light, offset] = sums.light;
        sums = Products {
            gradient: [
                residual.mul_add(f32x16::from_slice(simd, block.gradient_x), sums.gradient[0]),
                residual.mul_add(f32x16::from_slice(simd, block.gradient_y), sums.gradient[1]),
            ],
            light: [residual.mul_add(values - MID_LEVEL, light), offset + residual],
            energy: residual.mul_add(residual, sums.energy),
        };
    }
    sums
}

impl Texel for f32 {
    const CHANNELS: usize = 1;

    fn channels(self) -> [f32; 4] {
        [self, 0.0, 0.0, 0.0]
    }

    #[inline(always)]
    fn sample<S: Simd>(simd: S, current: &Image<Self>, places: &Places<S>) -> [f32x16<S>; 3] {
        [sample_grey(simd, current, places); 3]
    }
}

impl Texel for [f32; 4] {
    const CHANNELS: usize = 3;

    fn channels(self) -> [f32; 4] {
        self
    }

    #[inline(always)]
    fn sample<S: Simd>(simd: S, current: &Image<Self>, places: &Places<S>) -> [f32x16<S>; 3] {
        sample_colour(simd, current, &places.taps(current.width()))
    }
}

/// Grey levels. If the points share their taps, these are read as whole registers, which gives the same bits: a tap that a point
/// does not need has the weight zero.
#[inline(always)]
fn sample_grey<S: Simd>(simd: S, current: &Image<f32>, places: &Places<S>) -> f32x16<S> {
    match places.shared_taps(simd, current.size()) {
        Some(taps) => sample_shared(simd, current, &taps),
        None => sample_single(simd, current, &places.taps(current.width())),
    }
}

#[inline(always)]
fn sample_shared<S: Simd>(simd: S, current: &Image<f32>, taps: &SharedTaps<S>) -> f32x16<S> {
    let (stride, values) = (current.width(), &current.values()[taps.start..]);
    let mut sum = f32x16::splat(simd, 0.0);
    for (column, &weight) in taps.weights_x.iter().enumerate() {
        let mut down = f32x16::from_slice(simd, &values[column..][..LANES]) * taps.weights_y[0];
        for row in 1..SHARED {
            down =
                f32x16::from_slice(simd, &values[row * stride + column..][..LANES]).mul_add(taps.weights_y[row], down);
        }
        sum = down.mul_add(weight, sum);
    }
    sum
}

#[inline(always)]
fn sample_single<S: Simd>(simd: S, current: &Image<f32>, taps: &Taps<S>) -> f32x16<S> {
    let (stride, values) = (current.width(), current.values());
    let weights_y: [[f32; LANES]; 4] = taps.weights_y.map(SimdBase::to_array);
    let mut columns = [[0.0f32; 4]; LANES];
    for (k, columns) in columns.iter_mut().enumerate() {
        let rows = &values[taps.base[k] as usize..][..3 * stride + 4];
        let row = |j: usize| f32x4::from_slice(simd, &rows[j * stride..][..4]);
        let sum = row(0) * weights_y[0][k];
        let sum = row(1).mul_add(weights_y[1][k], sum);
        let sum = row(2).mul_add(weights_y[2][k], sum);
        *columns = row(3).mul_add(weights_y[3][k], sum).to_array();
    }
    let [column_0, column_1, column_2, column_3] = transpose(simd, &columns);
    let sum = column_0 * taps.weights_x[0];
    let sum = column_1.mul_add(taps.weights_x[1], sum);
    let sum = column_2.mul_add(taps.weights_x[2], sum);
    column_3.mul_add(taps.weights_x[3], sum)
}

#[inline(always)]
fn sample_colour<S: Simd>(simd: S, current: &Image<[f32; 4]>, taps: &Taps<S>) -> [f32x16<S>; 3] {
    let (stride, values) = (4 * current.width(), current.values().as_flattened());
    let weights_x: [[f32; LANES]; 4] = taps.weights_x.map(SimdBase::to_array);
    let weights_y: [[f32; LANES]; 4] = taps.weights_y.map(SimdBase::to_array);
    let mut samples = [[0.0f32; 4]; LANES];
    for (k, sample) in samples.iter_mut().enumerate() {
        let rows = &values[4 * taps.base[k] as usize..][..3 * stride + 16];
        let row = |j: usize| f32x16::from_slice(simd, &rows[j * stride..][..16]);
        let sum = row(0) * weights_y[0][k];
        let sum = row(1).mul_add(weights_y[1][k], sum);
        let sum = row(2).mul_add(weights_y[2][k], sum);
        let (left, right) = row(3).mul_add(weights_y[3][k], sum).split();
        let ((column_0, column_1), (column_2, column_3)) = (left.split(), right.split());
        let sum = column_0 * weights_x[0][k];
        let sum = column_1.mul_add(weights_x[1][k], sum);
        let sum = column_2.mul_add(weights_x[2][k], sum);
        *sample = column_3.mul_add(weights_x[3][k], sum).to_array();
    }
    let [red, green, blue, _] = transpose(simd, &samples);
    [red, green, blue]
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

    /// Samples neighbours from a column on, displaced by `motion`; returns whether their taps were shared.
    fn check(row: f32, first: f32, motion: impl Fn(usize) -> [f32; 2]) -> bool {
        let picture = Image::from_fn(SIZE.0, SIZE.1, |x, y| ((37 * x + 101 * y + 5 * x * y) % 251) as f32);
        let x: [f32; LANES] = std::array::from_fn(|k| first + k as f32 + motion(k)[0]);
        let y: [f32; LANES] = std::array::from_fn(|k| row + motion(k)[1]);
        dispatch!(Level::new(), simd => {
            let places = Places::in_row(f32x16::load_array(simd, x), f32x16::load_array(simd, y), SIZE);
            let inside = places.inside(simd).to_array();
            let single = sample_single(simd, &picture, &places.taps(SIZE.0)).to_array();
            let shared = places.shared_taps(simd, SIZE);
            let found = shared.as_ref().map(|taps| sample_shared(simd, &picture, taps).to_array());
            for k in 0..LANES {
                let is_inside = (1.0..=SIZE.0 as f32 - 2.0).contains(&x[k]) && (1.0..=SIZE.1 as f32 - 2.0).contains(&y[k]);
                assert_eq!(inside[k].to_bits(), f32::from(u8::from(is_inside)).to_bits(), "at {} {}", x[k], y[k]);
                if let Some(found) = found.filter(|_| is_inside) {
                    assert_eq!(found[k].to_bits(), single[k].to_bits(), "at {} {}", x[k], y[k]);
                }
            }
            shared.is_some()
        })
    }

    #[test]
    fn neighbours_that_move_alike_share_their_taps_and_have_the_same_bits() {
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

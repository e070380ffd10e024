//! The value of one pixel in the kernels: a grey level, or red, green, blue and a zero.
//!
//! Both kinds sample the current image with cubic B-splines on 4×4 px and multiply the residual with the template's
//! gradient, sixteen pixels at a time.

use super::grid::LANES;
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

/// The sampling of sixteen pixels: index of the upper left of 4×4 taps, and the weights of the taps.
pub(crate) struct Taps<S: Simd> {
    pub(crate) base: [u32; LANES],
    pub(crate) weights_x: [f32x16<S>; 4],
    pub(crate) weights_y: [f32x16<S>; 4],
}

/// Taps and weights for sixteen positions, and 1 where a position and its taps lie in a picture of this size, else 0.
#[inline(always)]
pub(super) fn locate<S: Simd>(
    simd: S,
    x: f32x16<S>,
    y: f32x16<S>,
    (width, height): (usize, usize),
) -> (Taps<S>, f32x16<S>) {
    // NaN is clamped to the lower bound. Its distance from there is NaN, so it counts as outside.
    let clamp = |place: f32x16<S>, size: usize| place.max_precise(1.0).min(size as f32 - 2.0 - 1.0 / 64.0);
    let (clamped_x, clamped_y) = (clamp(x, width), clamp(y, height));
    let (left, top) = (clamped_x.floor(), clamped_y.floor());
    let near = |place: f32x16<S>, clamped: f32x16<S>| (place - clamped).abs().simd_le(1.0 / 64.0);
    let inside = near(x, clamped_x) & near(y, clamped_y);
    let base = (top - 1.0) * width as f32 + (left - 1.0);
    let taps = Taps {
        base: base.to_int::<fearless_simd::u32x16<S>>().to_array(),
        weights_x: spline_weights(clamped_x - left),
        weights_y: spline_weights(clamped_y - top),
    };
    let one = f32x16::splat(simd, 1.0);
    (taps, inside.select(one, f32x16::splat(simd, 0.0)))
}

/// Cubic B-spline weights of the taps at −1, 0, 1 and 2 for a fraction `t`.
#[inline(always)]
fn spline_weights<S: Simd>(t: f32x16<S>) -> [f32x16<S>; 4] {
    let (sixth, s) = (1.0 / 6.0, t * -1.0 + 1.0);
    [s * s * s * sixth, (t * 0.5 - 1.0) * t * t + 2.0 / 3.0, (s * 0.5 - 1.0) * s * s + 2.0 / 3.0, t * t * t * sixth]
}

/// A pixel type for the affine kernels.
pub(crate) trait Texel: Copy + Default + Send + Sync + 'static {
    /// Channels that carry a signal.
    const CHANNELS: usize;

    /// The texel as channels, unused ones zero.
    fn channels(self) -> [f32; 4];

    /// Sixteen samples of the current image: one register for each channel, the unused ones zero or repeated.
    fn sample<S: Simd>(simd: S, current: &Image<Self>, taps: &Taps<S>) -> [f32x16<S>; 3];
}

/// The products of sixteen pixels. `block` gives the template's channels, `gain` scales the current image.
#[inline(always)]
pub(crate) fn products<'a, S: Simd, T: Texel>(
    simd: S,
    current: &Image<T>,
    gain: f32,
    taps: &Taps<S>,
    block: impl Fn(usize) -> TemplateBlock<'a>,
) -> Products<S> {
    let samples = T::sample(simd, current, taps);
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
    fn sample<S: Simd>(simd: S, current: &Image<Self>, taps: &Taps<S>) -> [f32x16<S>; 3] {
        [sample_grey(simd, current, taps); 3]
    }
}

impl Texel for [f32; 4] {
    const CHANNELS: usize = 3;

    fn channels(self) -> [f32; 4] {
        self
    }

    #[inline(always)]
    fn sample<S: Simd>(simd: S, current: &Image<Self>, taps: &Taps<S>) -> [f32x16<S>; 3] {
        sample_colour(simd, current, taps)
    }
}

#[inline(always)]
fn sample_grey<S: Simd>(simd: S, current: &Image<f32>, taps: &Taps<S>) -> f32x16<S> {
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

//! What one pixel of a picture is to the kernels: a grey level, or red, green, blue and a zero.
//!
//! Both kinds sample the current image with cubic B-splines on 4×4 px and multiply the residual with the template's
//! gradient, sixteen pixels at a time.

use super::grid::LANES;
use fearless_simd::{Simd, f32x4, f32x16, prelude::*};
use fingervision_image::Image;

/// Sixteen pixels of the template.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TemplateBlock<'a, T> {
    pub(crate) texels: &'a [T],
    pub(crate) gradient_x: &'a [T],
    pub(crate) gradient_y: &'a [T],
}

/// Sums over the channels of products with the residual `r = T − I(x + u)`, sixteen pixels of each.
pub(crate) struct Products<S: Simd> {
    /// `Σ r ∂T/∂x` and `Σ r ∂T/∂y`.
    pub(crate) gradient: [f32x16<S>; 2],
    /// `Σ r (T − MID_LEVEL)` and `Σ r`: what a change of light explains.
    pub(crate) light: [f32x16<S>; 2],
    /// `Σ r²`.
    pub(crate) energy: f32x16<S>,
}

/// Grey level that template values are measured from, so that gain and offset decouple.
pub(crate) const MID_LEVEL: f32 = 128.0;

/// Where sixteen pixels are sampled: index of the upper left of 4×4 taps, and the taps' weights.
pub(crate) struct Taps<S: Simd> {
    pub(crate) base: [u32; LANES],
    pub(crate) weights_x: [f32x16<S>; 4],
    pub(crate) weights_y: [f32x16<S>; 4],
}

/// A pixel that the affine kernels can work on.
pub(crate) trait Texel: Copy + Default + Send + Sync + 'static {
    /// Channels that carry a signal.
    const CHANNELS: usize;

    /// The texel as channels, unused ones zero.
    fn channels(self) -> [f32; 4];

    /// A texel from channels.
    fn from_channels(channels: [f32; 4]) -> Self;

    fn products<S: Simd>(
        simd: S,
        current: &Image<Self>,
        taps: &Taps<S>,
        template: TemplateBlock<'_, Self>,
    ) -> Products<S>;
}

impl Texel for f32 {
    const CHANNELS: usize = 1;

    fn channels(self) -> [f32; 4] {
        [self, 0.0, 0.0, 0.0]
    }

    fn from_channels(channels: [f32; 4]) -> Self {
        channels[0]
    }

    #[inline(always)]
    fn products<S: Simd>(
        simd: S,
        current: &Image<Self>,
        taps: &Taps<S>,
        template: TemplateBlock<'_, Self>,
    ) -> Products<S> {
        let sample = sample_grey(simd, current, taps);
        let texels = f32x16::from_slice(simd, template.texels);
        let residual = texels - sample;
        Products {
            gradient: [
                residual * f32x16::from_slice(simd, template.gradient_x),
                residual * f32x16::from_slice(simd, template.gradient_y),
            ],
            light: [residual * (texels - MID_LEVEL), residual],
            energy: residual * residual,
        }
    }
}

impl Texel for [f32; 4] {
    const CHANNELS: usize = 3;

    fn channels(self) -> [f32; 4] {
        self
    }

    fn from_channels(channels: [f32; 4]) -> Self {
        channels
    }

    #[inline(always)]
    fn products<S: Simd>(
        simd: S,
        current: &Image<Self>,
        taps: &Taps<S>,
        template: TemplateBlock<'_, Self>,
    ) -> Products<S> {
        let samples = sample_colour(simd, current, taps);
        let texels = load_four(simd, template.texels);
        let gradient_x = load_four(simd, template.gradient_x);
        let gradient_y = load_four(simd, template.gradient_y);
        let residual: [_; 4] = std::array::from_fn(|k| texels[k] - samples[k]);
        Products {
            gradient: [
                sum_channels(std::array::from_fn(|k| residual[k] * gradient_x[k])),
                sum_channels(std::array::from_fn(|k| residual[k] * gradient_y[k])),
            ],
            light: [
                sum_channels(std::array::from_fn(|k| residual[k] * (texels[k] - MID_LEVEL))),
                sum_channels(residual),
            ],
            energy: sum_channels(std::array::from_fn(|k| residual[k] * residual[k])),
        }
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
    let [a, b, c, d] = load_four(simd, &columns);
    let (even_low, odd_low) = a.deinterleave(b);
    let (even_high, odd_high) = c.deinterleave(d);
    let (column_0, column_2) = even_low.deinterleave(even_high);
    let (column_1, column_3) = odd_low.deinterleave(odd_high);
    let sum = column_0 * taps.weights_x[0];
    let sum = column_1.mul_add(taps.weights_x[1], sum);
    let sum = column_2.mul_add(taps.weights_x[2], sum);
    column_3.mul_add(taps.weights_x[3], sum)
}

#[inline(always)]
fn sample_colour<S: Simd>(simd: S, current: &Image<[f32; 4]>, taps: &Taps<S>) -> [f32x16<S>; 4] {
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
    load_four(simd, &samples)
}

/// Sixteen texels as four registers of four texels.
#[inline(always)]
fn load_four<S: Simd>(simd: S, texels: &[[f32; 4]]) -> [f32x16<S>; 4] {
    let values = &texels.as_flattened()[..4 * LANES];
    std::array::from_fn(|k| f32x16::from_slice(simd, &values[LANES * k..][..LANES]))
}

/// The sum over the channels of each of sixteen texels.
#[inline(always)]
fn sum_channels<S: Simd>([a, b, c, d]: [f32x16<S>; 4]) -> f32x16<S> {
    let pair = |low: f32x16<S>, high: f32x16<S>| {
        let (even, odd) = low.deinterleave(high);
        even + odd
    };
    pair(pair(a, b), pair(c, d))
}

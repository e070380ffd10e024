//! The products of the residual with the template, summed over the channels, sixteen pixels at a time.

use fearless_simd::{Simd, f32x16, prelude::*};
use fingervision_image::Image;

/// Grey level subtracted from template values, so that gain and offset decouple.
pub(crate) const MID_LEVEL: f32 = 128.0;

/// The current picture on one level, as grey or as red, green and blue.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Current<'a, const CHANNELS: usize> {
    /// All of one size.
    pub(crate) channels: [&'a Image<f32>; CHANNELS],
    /// The gain that brings its mean to the reference's.
    pub(crate) gain: f32,
}

impl<'a> Current<'a, 1> {
    /// A grey picture.
    pub(crate) fn grey(image: &'a Image<f32>, gain: f32) -> Self {
        Self { channels: [image], gain }
    }
}

impl<'a> Current<'a, 3> {
    /// A picture in colour.
    pub(crate) fn colour(channels: &'a [Image<f32>; 3], gain: f32) -> Self {
        Self { channels: channels.each_ref(), gain }
    }
}

impl<const CHANNELS: usize> Current<'_, CHANNELS> {
    /// Columns and rows, px.
    #[inline(always)]
    pub(crate) fn size(&self) -> (usize, usize) {
        self.channels[0].size()
    }
}

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

/// The products of sixteen pixels. `samples` are the channels of the current picture there, which `gain` scales; `block` gives the
/// template's channels.
#[inline(always)]
pub(crate) fn products<'a, S: Simd, const CHANNELS: usize>(
    simd: S,
    samples: [f32x16<S>; CHANNELS],
    gain: f32,
    block: impl Fn(usize) -> TemplateBlock<'a>,
) -> Products<S> {
    let zero = f32x16::splat(simd, 0.0);
    let mut sums = Products { gradient: [zero; 2], light: [zero; 2], energy: zero };
    for (channel, sample) in samples.into_iter().enumerate() {
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

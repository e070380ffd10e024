//! The sums over a cell: sixteen pixels that four fine patches share.

use super::grid::{CELL, CORNERS, CornerWeights, STRIDE};
use crate::affine::grid::MARGIN;
use crate::affine::places::Places;
use crate::affine::products::{Current, MID_LEVEL, TemplateBlock, products};
use crate::affine::sampling::sample;
use crate::affine::template::{MOMENTS, Template};
use fearless_simd::{Simd, f32x16, prelude::*};
use fearless_simd_macros::simd;

/// Number of sums over the residual: six for the gradient, two for light, one for the energy.
pub(super) const RESIDUALS: usize = 9;

/// For each sum, the index of its product and of its weights: `1, ξ, η` for both gradients, `1` for gain, offset and
/// energy.
const SUMS: [(usize, usize); RESIDUALS] = [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2), (2, 0), (3, 0), (4, 0)];

/// Values, x and y gradients of up to three channels of a cell of the template.
struct CellTemplate {
    channels: [[[f32; CELL]; 3]; 3],
}

impl CellTemplate {
    /// The pixels of the cell whose upper left one is `(x, y)`.
    #[inline(always)]
    fn of(template: &Template, channels: usize, (x, y): (usize, usize)) -> Self {
        let mut cell = Self { channels: [[[0.0; CELL]; 3]; 3] };
        for (channel, planes) in cell.channels.iter_mut().enumerate().take(channels) {
            for row in 0..STRIDE {
                let block = template.block(channel, x + MARGIN, y + row + MARGIN);
                let lines = [block.values, block.gradient_x, block.gradient_y];
                for (plane, line) in planes.iter_mut().zip(lines) {
                    plane[row * STRIDE..][..STRIDE].copy_from_slice(&line[..STRIDE]);
                }
            }
        }
        cell
    }

    #[inline(always)]
    fn block(&self, channel: usize) -> TemplateBlock<'_> {
        let [values, gradient_x, gradient_y] = &self.channels[channel];
        TemplateBlock { values, gradient_x, gradient_y }
    }
}

/// The moments of the template over the cell for each corner, in the order of [`MOMENTS`].
#[simd]
pub(super) fn template_moments<S: Simd>(
    simd: S,
    template: &Template,
    channels: usize,
    weights: &CornerWeights<6>,
    upper_left: (usize, usize),
) -> [[f32; MOMENTS]; CORNERS] {
    let cell = CellTemplate::of(template, channels, upper_left);
    let zero = f32x16::splat(simd, 0.0);
    let mut sums = [zero; 10];
    let one = f32x16::splat(simd, 1.0);
    for [values, gradient_x, gradient_y] in &cell.channels[..channels] {
        let t = f32x16::load_array_ref(simd, values) - MID_LEVEL;
        let (gx, gy) = (f32x16::load_array_ref(simd, gradient_x), f32x16::load_array_ref(simd, gradient_y));
        for (sum, product) in sums.iter_mut().zip([gx * gx, gx * gy, gy * gy, gx * t, gx, gy * t, gy, t * t, t, one]) {
            *sum += product;
        }
    }
    let mut moments = [[0.0; MOMENTS]; CORNERS];
    for (moments, weights) in moments.iter_mut().zip(weights) {
        let mut place = 0;
        for (product, &sum) in sums.iter().enumerate() {
            let powers = [6, 6, 6, 3, 3, 3, 3, 1, 1, 1][product];
            for weights in &weights[..powers] {
                moments[place] = (sum * f32x16::load_array_ref(simd, weights)).reduce_sum();
                place += 1;
            }
        }
    }
    moments
}

/// The sums over the residual for each corner: `(1, ξ, η)` of `r ∂T/∂x` and of `r ∂T/∂y`, two of light, the energy.
/// `flow` is the displacement of the sixteen pixels.
#[simd]
pub(super) fn residuals<S: Simd, const CHANNELS: usize>(
    simd: S,
    template: &Template,
    current: Current<'_, CHANNELS>,
    weights: &CornerWeights<6>,
    (left, top): (usize, usize),
    flow: [[f32; CELL]; 2],
) -> [[f32; RESIDUALS]; CORNERS] {
    let cell = CellTemplate::of(template, CHANNELS, (left, top));
    let (mut columns, mut rows) = ([0.0; CELL], [0.0; CELL]);
    for (k, (column, row)) in columns.iter_mut().zip(&mut rows).enumerate() {
        (*column, *row) = ((left + k % STRIDE) as f32, (top + k / STRIDE) as f32);
    }
    let (column, row) = (f32x16::load_array(simd, columns), f32x16::load_array(simd, rows));
    let (u, v) = (f32x16::load_array(simd, flow[0]), f32x16::load_array(simd, flow[1]));
    let places = Places::of(column + u, row + v, current.size());
    let inside = places.inside(simd);
    let found = products(simd, sample(simd, current.channels, &places), current.gain, |channel| cell.block(channel));
    let (gx, gy) = (found.gradient[0] * inside, found.gradient[1] * inside);
    let (gain, offset, energy) = (found.light[0] * inside, found.light[1] * inside, found.energy * inside);
    let planes = [gx, gy, gain, offset, energy];
    let mut sums = [[0.0; RESIDUALS]; CORNERS];
    // Loops, because the compiler does not use the instruction set in closures.
    for (sums, weights) in sums.iter_mut().zip(weights) {
        for (place, &(plane, power)) in SUMS.iter().enumerate() {
            sums[place] = (planes[plane] * f32x16::load_array_ref(simd, &weights[power])).reduce_sum();
        }
    }
    sums
}

/// The displacement of a cell's pixels: the bicubic Hermite interpolant of its corners' values, slopes and twists.
#[simd]
pub(super) fn interpolate<S: Simd>(simd: S, basis: &CornerWeights<4>, corners: [[f32; 4]; CORNERS]) -> [f32; CELL] {
    let mut sum = f32x16::splat(simd, 0.0);
    for (basis, values) in basis.iter().zip(corners) {
        for (basis, value) in basis.iter().zip(values) {
            sum = f32x16::load_array_ref(simd, basis).mul_add(value, sum);
        }
    }
    sum.to_array()
}

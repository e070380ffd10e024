//! One layer of the network.

use fearless_simd::{Level, dispatch, prelude::*};
use fearless_simd_macros::simd;

use super::plane::Plane;

/// Output channels computed together: one or two registers.
const LANES: usize = 16;
/// Cells of a row computed together, which share the weights they read.
const CELLS: usize = 4;

/// What becomes of a layer's sum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Then {
    /// Nothing.
    Keep,
    /// Negative values become zero.
    Rectify,
    /// Negative values become zero, and what went in is added: the layer learns a change.
    RectifyAndAdd,
}

/// A convolution of 3×3 or 1×1 cells over all channels, at every cell or at every second one.
#[derive(Debug, Clone)]
pub(super) struct Convolution {
    inputs: usize,
    outputs: usize,
    side: usize,
    stride: usize,
    /// In blocks of [`LANES`] outputs: `[block][row][column][input][lane]`, zero beyond the last output.
    weights: Vec<f32>,
    bias: Vec<f32>,
}

impl Convolution {
    /// From weights in the order `[output][input][row][column]` followed by a bias for each output.
    pub(super) fn new(shape: Shape, values: &[f32]) -> Self {
        let Shape { inputs, outputs, side, stride } = shape;
        let blocks = outputs.div_ceil(LANES);
        let (weights, bias) = values.split_at(outputs * inputs * side * side);
        let mut ordered = vec![0.0; blocks * side * side * inputs * LANES];
        for (index, &weight) in weights.iter().enumerate() {
            let (output, rest) = (index / (inputs * side * side), index % (inputs * side * side));
            let (input, tap) = (rest / (side * side), rest % (side * side));
            let (block, lane) = (output / LANES, output % LANES);
            ordered[((block * side * side + tap) * inputs + input) * LANES + lane] = weight;
        }
        let mut padded = bias.to_vec();
        padded.resize(blocks * LANES, 0.0);
        Self { inputs, outputs, side, stride, weights: ordered, bias: padded }
    }

    /// Applies the layer. `to` has a cell for every `stride`-th of `from`.
    pub(super) fn apply(&self, level: Level, from: &Plane, to: &mut Plane, then: Then) {
        debug_assert_eq!((from.channels, to.channels), (self.inputs, self.outputs), "channels of the layer");
        dispatch!(level, simd => self.run(simd, from, to, then));
    }

    #[simd]
    fn run<S: Simd>(&self, simd: S, from: &Plane, to: &mut Plane, then: Then) {
        let per_block = self.side * self.side * self.inputs * LANES;
        for row in 0..to.rows {
            for (block, weights) in self.weights.chunks_exact(per_block).enumerate() {
                let first = block * LANES;
                let count = LANES.min(self.outputs - first);
                let bias: &[f32; LANES] = self.bias[first..].first_chunk().expect("biases fill whole blocks");
                for column in (0..to.columns).step_by(CELLS) {
                    // The last group of a row overlaps the one before it.
                    let column = column.min(to.columns - CELLS);
                    let sums = self.sum(simd, weights, bias, from, (column, row));
                    for (cell, sums) in (column..).zip(&sums) {
                        let at = cell * self.outputs + first..cell * self.outputs + first + count;
                        let before = if then == Then::RectifyAndAdd { &from.row(row)[at.clone()] } else { &[] };
                        finish(&mut to.row_mut(row)[at], sums, before, then);
                    }
                }
            }
        }
    }

    /// The sums of [`CELLS`] neighbouring cells for one block of outputs.
    #[simd]
    fn sum<S: Simd>(
        &self,
        _: S,
        weights: &[f32],
        bias: &[f32; LANES],
        from: &Plane,
        (column, row): (usize, usize),
    ) -> [[f32; LANES]; CELLS] {
        let (stride, step) = (from.stride(), self.stride * self.inputs);
        // The rim is one cell wide: a kernel of 1×1 begins in its middle.
        let rim = usize::from(self.side == 1);
        let mut sums = [*bias; CELLS];
        for tap_row in 0..self.side {
            let start = (row * self.stride + tap_row + rim) * stride + column * step + rim * self.inputs;
            let taps = self.side * self.inputs;
            let weights = &weights[tap_row * taps * LANES..][..taps * LANES];
            let [a, b, c, d]: [&[f32]; CELLS] =
                std::array::from_fn(|cell| &from.values()[start + cell * step..][..taps]);
            for (((weights, a), b), (c, d)) in weights.as_chunks::<LANES>().0.iter().zip(a).zip(b).zip(c.iter().zip(d))
            {
                for lane in 0..LANES {
                    sums[0][lane] += a * weights[lane];
                    sums[1][lane] += b * weights[lane];
                    sums[2][lane] += c * weights[lane];
                    sums[3][lane] += d * weights[lane];
                }
            }
        }
        sums
    }
}

/// Numbers that make a layer's shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Shape {
    pub(super) inputs: usize,
    pub(super) outputs: usize,
    pub(super) side: usize,
    pub(super) stride: usize,
}

impl Shape {
    /// Weights and biases.
    pub(super) fn len(self) -> usize {
        self.outputs * (self.inputs * self.side * self.side + 1)
    }
}

#[inline]
fn finish(to: &mut [f32], sums: &[f32; LANES], before: &[f32], then: Then) {
    match then {
        Then::Keep => to.copy_from_slice(&sums[..to.len()]),
        Then::Rectify => {
            for (to, sum) in to.iter_mut().zip(sums) {
                *to = sum.max(0.0);
            }
        }
        Then::RectifyAndAdd => {
            for ((to, sum), before) in to.iter_mut().zip(sums).zip(before) {
                *to = sum.max(0.0) + before;
            }
        }
    }
}

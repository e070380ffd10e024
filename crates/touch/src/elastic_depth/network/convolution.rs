//! One layer of the network.

use fearless_simd::{Level, dispatch, f32x16, prelude::*};
use fearless_simd_macros::simd;
use fingervision_flow::Team;

use super::finish::{Activation, Finish};
use super::plane::{Plane, Rows};
use super::shape::{LANES, Shape, TILE};
use super::winograd;

/// Cells of a row computed together: they share the weights that they read, and their sums fill the registers of AVX2.
pub(super) const CELLS: usize = 6;

/// Least number of cells of a layer that two threads share: each then has more tiles than are computed together.
const LEAST_SHARED: usize = 96;

/// A convolution of 3×3 or 1×1 cells over all channels, at every cell or at every second one.
#[derive(Debug, Clone)]
pub(super) struct Convolution {
    inputs: usize,
    side: usize,
    stride: usize,
    weights: Weights,
    bias: Vec<f32>,
}

/// The weights in blocks of [`LANES`] outputs, zero beyond the last output.
#[derive(Debug, Clone)]
enum Weights {
    /// Those of the layer: `[block][row][column][input][lane]`.
    Plain(Vec<f32>),
    /// See [`winograd::kernels`].
    Winograd(Vec<f32>),
}

impl Convolution {
    /// From weights in the order `[output][input][row][column]` followed by a bias for each output.
    pub(super) fn new(shape: Shape, values: &[f32]) -> Self {
        let Shape { inputs, outputs, side, stride } = shape;
        let blocks = outputs.div_ceil(LANES);
        let (weights, bias) = values.split_at(outputs * inputs * side * side);
        let mut padded = bias.to_vec();
        padded.resize(blocks * LANES, 0.0);
        let weights = if winograd::applies(shape) {
            Weights::Winograd(winograd::kernels(shape, weights))
        } else {
            Weights::Plain(in_blocks(shape, weights))
        };
        Self { inputs, side, stride, weights, bias: padded }
    }

    /// Applies the layer. `to` has a cell for every `stride`-th of `from`, and its channels are whole blocks of [`LANES`]: zeros
    /// follow the last output.
    pub(super) fn apply(&self, level: Level, team: &Team, from: &Plane, to: &mut Plane, then: Activation<'_>) {
        assert_eq!((from.channels, to.channels), (self.inputs, self.bias.len()), "channels of the layer");
        let (cells, rows) = (to.rows * to.columns, to.rows);
        let to = to.rows_mut();
        if !team.is_shared() || cells < LEAST_SHARED {
            self.apply_to(level, from, to, then);
            return;
        }
        // Tiles are two rows high.
        let (upper, lower) = to.split_at((rows / 2).next_multiple_of(TILE));
        team.join(|| self.apply_to(level, from, upper, then), || self.apply_to(level, from, lower, then));
    }

    /// Applies the layer to some rows.
    fn apply_to(&self, level: Level, from: &Plane, to: Rows<'_>, then: Activation<'_>) {
        let finish = Finish { from, to, then };
        match &self.weights {
            Weights::Plain(weights) => dispatch!(level, simd => self.run(simd, weights, finish)),
            Weights::Winograd(kernels) => {
                dispatch!(level, simd => winograd::run(simd, (kernels, &self.bias), finish));
            }
        }
    }

    #[simd]
    fn run<S: Simd>(&self, simd: S, weights: &[f32], mut finish: Finish<'_>) {
        let per_block = self.side * self.side * self.inputs * LANES;
        let columns = finish.to.columns;
        for row in finish.to.range() {
            for (block, weights) in weights.chunks_exact(per_block).enumerate() {
                for column in (0..columns).step_by(CELLS) {
                    // The last group of a row overlaps the previous one.
                    let column = column.min(columns - CELLS);
                    let sums = self.sum(simd, weights, self.bias(block), finish.from, (column, row));
                    for (cell, sums) in (column..).zip(sums) {
                        finish.cell(simd, (block, cell, row), sums);
                    }
                }
            }
        }
    }

    /// The biases of a block of outputs.
    #[inline(always)]
    fn bias(&self, block: usize) -> &[f32; LANES] {
        self.bias[block * LANES..].first_chunk().expect("biases fill whole blocks")
    }

    /// The sums of [`CELLS`] neighbouring cells for one block of outputs.
    #[simd]
    fn sum<S: Simd>(
        &self,
        simd: S,
        weights: &[f32],
        bias: &[f32; LANES],
        from: &Plane,
        (column, row): (usize, usize),
    ) -> [f32x16<S>; CELLS] {
        let (stride, step) = (from.stride(), self.stride * self.inputs);
        // The rim is one cell wide: a kernel of 1×1 begins in its middle.
        let rim = usize::from(self.side == 1);
        let mut sums = [f32x16::from_slice(simd, bias); CELLS];
        for tap_row in 0..self.side {
            let start = (row * self.stride + tap_row + rim) * stride + column * step + rim * self.inputs;
            let taps = self.side * self.inputs;
            let weights = &weights[tap_row * taps * LANES..][..taps * LANES];
            let [a, b, c, d, e, f]: [&[f32]; CELLS] =
                std::array::from_fn(|cell| &from.values()[start + cell * step..][..taps]);
            for (tap, weights) in weights.as_chunks::<LANES>().0.iter().enumerate() {
                let weights = f32x16::from_slice(simd, weights);
                sums[0] = weights.mul_add(f32x16::splat(simd, a[tap]), sums[0]);
                sums[1] = weights.mul_add(f32x16::splat(simd, b[tap]), sums[1]);
                sums[2] = weights.mul_add(f32x16::splat(simd, c[tap]), sums[2]);
                sums[3] = weights.mul_add(f32x16::splat(simd, d[tap]), sums[3]);
                sums[4] = weights.mul_add(f32x16::splat(simd, e[tap]), sums[4]);
                sums[5] = weights.mul_add(f32x16::splat(simd, f[tap]), sums[5]);
            }
        }
        sums
    }
}

/// Weights `[output][input][row][column]` in blocks: see [`Weights::Plain`].
fn in_blocks(Shape { inputs, outputs, side, .. }: Shape, weights: &[f32]) -> Vec<f32> {
    let mut ordered = vec![0.0; outputs.div_ceil(LANES) * side * side * inputs * LANES];
    for (index, &weight) in weights.iter().enumerate() {
        let (output, rest) = (index / (inputs * side * side), index % (inputs * side * side));
        let (input, tap) = (rest / (side * side), rest % (side * side));
        let (block, lane) = (output / LANES, output % LANES);
        ordered[((block * side * side + tap) * inputs + input) * LANES + lane] = weight;
    }
    ordered
}

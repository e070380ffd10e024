//! One layer of the network.

use fearless_simd::{Level, dispatch, f32x16, prelude::*};
use fearless_simd_macros::simd;
use fingervision_flow::Team;

use super::plane::{Plane, Rows};
use super::shape::{LANES, Shape, TILE};
use super::winograd;

/// Cells of a row computed together: they share the weights that they read, and their sums fill the registers of AVX2.
pub(super) const CELLS: usize = 6;

/// Least number of cells of a layer that two threads share: each then has more tiles than are computed together.
const LEAST_SHARED: usize = 96;

/// The operation on the sums of a layer.
#[derive(Debug, Clone, Copy)]
pub(super) enum Activation<'a> {
    /// Nothing.
    Keep,
    /// Negative values become zero.
    Rectify,
    /// Negative values become zero, and the input is added: the layer learns a change.
    RectifyAndAdd,
    /// A plane of half the resolution is added, each of its cells to 2×2, then negative values become zero.
    AddGrownAndRectify(&'a Plane),
}

/// A convolution of 3×3 or 1×1 cells over all channels, at every cell or at every second one.
#[derive(Debug, Clone)]
pub(super) struct Convolution {
    inputs: usize,
    outputs: usize,
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
        Self { inputs, outputs, side, stride, weights, bias: padded }
    }

    /// Applies the layer. `to` has a cell for every `stride`-th of `from`.
    pub(super) fn apply(&self, level: Level, team: &Team, from: &Plane, to: &mut Plane, then: Activation<'_>) {
        assert_eq!((from.channels, to.channels), (self.inputs, self.outputs), "channels of the layer");
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
    fn apply_to(&self, level: Level, from: &Plane, mut to: Rows<'_>, then: Activation<'_>) {
        match &self.weights {
            Weights::Plain(weights) => dispatch!(level, simd => self.run(simd, weights, from, to, then)),
            Weights::Winograd(kernels) => {
                let cells = (to.columns, to.range());
                let finish = |place: (usize, usize, usize), sums: &[f32; LANES]| {
                    self.finish(place, sums, from, &mut to, then);
                };
                dispatch!(level, simd => winograd::run(simd, (kernels, &self.bias), from, cells, finish));
            }
        }
    }

    #[simd]
    fn run<S: Simd>(&self, simd: S, weights: &[f32], from: &Plane, mut to: Rows<'_>, then: Activation<'_>) {
        let per_block = self.side * self.side * self.inputs * LANES;
        for row in to.range() {
            for (block, weights) in weights.chunks_exact(per_block).enumerate() {
                for column in (0..to.columns).step_by(CELLS) {
                    // The last group of a row overlaps the previous one.
                    let column = column.min(to.columns - CELLS);
                    let sums = self.sum(simd, weights, self.bias(block), from, (column, row));
                    for (cell, sums) in (column..).zip(&sums) {
                        self.finish((block, cell, row), sums, from, &mut to, then);
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

    /// Writes a cell's channels of one block of outputs, given their sums.
    #[inline(always)]
    fn finish(
        &self,
        (block, column, row): (usize, usize, usize),
        sums: &[f32; LANES],
        from: &Plane,
        to: &mut Rows<'_>,
        then: Activation<'_>,
    ) {
        let first = block * LANES;
        let count = LANES.min(self.outputs - first);
        let to = to.cell_mut((column, row), first, count);
        match then {
            Activation::Keep => to.copy_from_slice(&sums[..count]),
            Activation::Rectify => write(to, sums, &[0.0; LANES], |sum, _| sum.max(0.0)),
            Activation::RectifyAndAdd => {
                write(to, sums, from.cell((column, row), first, count), |sum, before| sum.max(0.0) + before);
            }
            Activation::AddGrownAndRectify(coarse) => {
                let coarse = coarse.cell((column / 2, row / 2), first, count);
                write(to, sums, coarse, |sum, coarse| (sum + coarse).max(0.0));
            }
        }
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
    ) -> [[f32; LANES]; CELLS] {
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
        sums.map(|sums| *sums.as_slice().first_chunk().expect("as many lanes"))
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

/// Writes what `combine` returns for each sum and the value next to it.
#[inline(always)]
fn write(to: &mut [f32], sums: &[f32; LANES], beside: &[f32], combine: impl Fn(f32, f32) -> f32) {
    // Of a known length: these loops are vectorised.
    if let ([to], [beside, ..]) = (to.as_chunks_mut::<LANES>().0, beside.as_chunks::<LANES>().0) {
        for k in 0..LANES {
            to[k] = combine(sums[k], beside[k]);
        }
        return;
    }
    for ((to, &sum), &beside) in to.iter_mut().zip(sums).zip(beside) {
        *to = combine(sum, beside);
    }
}

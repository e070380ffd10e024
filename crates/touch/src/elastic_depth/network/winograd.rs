//! Convolutions of 3×3 cells with fewer products: the minimal filtering F(2×2, 3×3) of [Lavin2016].
//!
//! Tiles of 2×2 cells are computed from 4×4 inputs `d` and a kernel `g` as `Aᵀ [(G g Gᵀ) ∘ (Bᵀ d B)] A`, summed over the
//! inputs between the brackets. A cell takes 4 products for each input and output in place of 9.

use fearless_simd::{Simd, f32x16, prelude::*};
use fearless_simd_macros::simd;

use super::finish::Finish;
use super::plane::Plane;
use super::shape::{LANES, Shape, TILE};

/// Inputs along a tile.
const REACH: usize = 4;
/// Products of a tile for each input and output.
const POINTS: usize = REACH * REACH;
/// Tiles computed together: they share the weights that they read, and their sums fill the registers of AVX2.
const TILES: usize = 6;
/// Inputs whose products follow each other in a pass of the innermost loop.
const PAIR: usize = 2;
/// Largest number of input channels; the transformed inputs of [`TILES`] tiles then fit into the first cache.
const MOST_INPUTS: usize = 64;

/// Transformed inputs of some tiles: `[point][tile][input]`.
type Spread = [[[f32; MOST_INPUTS]; TILES]; POINTS];

/// Whether this method can be used for a layer: the inputs of a cell fill whole registers.
pub(super) fn applies(shape: Shape) -> bool {
    let is_even = shape.inputs.is_multiple_of(PAIR);
    shape.side == 3 && shape.stride == 1 && is_even && (LANES..=MOST_INPUTS).contains(&shape.inputs)
}

/// The kernels `G g Gᵀ` in blocks of [`LANES`] outputs: `[block][point][input][lane]`, zero beyond the last output; from
/// weights `[output][input][row][column]`.
pub(super) fn kernels(shape: Shape, weights: &[f32]) -> Vec<f32> {
    let Shape { inputs, outputs, .. } = shape;
    let mut kernels = vec![0.0; outputs.div_ceil(LANES) * POINTS * inputs * LANES];
    for (index, kernel) in weights.as_chunks::<9>().0.iter().enumerate() {
        let (output, input) = (index / inputs, index % inputs);
        let rows: [_; 3] =
            std::array::from_fn(|row| filter(std::array::from_fn(|column| f64::from(kernel[3 * row + column]))));
        for column in 0..REACH {
            let values = filter(std::array::from_fn(|row| rows[row][column]));
            for (row, value) in values.into_iter().enumerate() {
                let point = REACH * row + column;
                let place = ((output / LANES * POINTS + point) * inputs + input) * LANES + output % LANES;
                kernels[place] = value as f32;
            }
        }
    }
    kernels
}

/// `G g`.
fn filter([a, b, c]: [f64; 3]) -> [f64; REACH] {
    [a, 0.5 * (a + b + c), 0.5 * (a - b + c), c]
}

/// `Bᵀ d`.
#[inline(always)]
fn spread<S: Simd>([a, b, c, d]: [f32x16<S>; REACH]) -> [f32x16<S>; REACH] {
    [a - c, b + c, c - b, b - d]
}

/// `Aᵀ m`.
#[inline(always)]
fn gather<S: Simd>([a, b, c, d]: [f32x16<S>; REACH]) -> [f32x16<S>; TILE] {
    [a + b + c, b - c - d]
}

/// Applies a layer with these kernels and biases: passes the sums of each cell on.
#[simd]
#[expect(clippy::large_stack_arrays, reason = "memory of a layer; nothing is allocated for a frame")]
pub(super) fn run<S: Simd>(simd: S, (kernels, biases): (&[f32], &[f32]), mut finish: Finish<'_>) {
    let (from, columns, rows) = (finish.from, finish.to.columns, finish.to.range());
    let inputs = from.channels;
    let mut spread = [[[0.0; MOST_INPUTS]; TILES]; POINTS];
    let mut sums = [[[0.0; LANES]; TILES]; POINTS];
    let across = columns.div_ceil(TILE);
    let count = across * rows.len().div_ceil(TILE);
    for first in (0..count).step_by(TILES) {
        // The last group overlaps the previous one.
        let first = first.min(count - TILES);
        let places: [_; TILES] = std::array::from_fn(|k| {
            let tile = first + k;
            (tile % across * TILE, rows.start + tile / across * TILE)
        });
        for (tile, place) in places.into_iter().enumerate() {
            spread_tile(simd, from, place, tile, &mut spread);
        }
        let blocks = kernels.chunks_exact(POINTS * inputs * LANES).zip(biases.as_chunks::<LANES>().0);
        for (block, (kernels, bias)) in blocks.enumerate() {
            let points = kernels.chunks_exact(inputs * LANES).zip(&spread);
            for (sums, (kernels, spread)) in sums.iter_mut().zip(points) {
                multiply(simd, kernels, spread, sums);
            }
            for (tile, (column, row)) in places.into_iter().enumerate() {
                let cells = gather_tile(simd, &sums, tile, bias);
                for (at, sums) in cells.into_iter().enumerate() {
                    let (column, row) = (column + at % TILE, row + at / TILE);
                    if column < columns && row < rows.end {
                        finish.cell(simd, (block, column, row), sums);
                    }
                }
            }
        }
    }
}

/// `Bᵀ d B` of a tile whose upper left cell is at `(column, row)`, for all inputs; `out` is `[point][tile][input]`.
#[inline(always)]
fn spread_tile<S: Simd>(simd: S, from: &Plane, (column, row): (usize, usize), tile: usize, out: &mut Spread) {
    let (inputs, stride) = (from.channels, from.stride());
    let start = row * stride + column * inputs;
    let rows: [_; REACH] = std::array::from_fn(|j| &from.values()[start + j * stride..][..REACH * inputs]);
    for first in (0..inputs).step_by(LANES) {
        // The last inputs overlap the previous ones.
        let first = first.min(inputs - LANES);
        let columns: [_; REACH] = std::array::from_fn(|i| {
            let cell = i * inputs + first;
            spread(rows.map(|row| f32x16::from_slice(simd, &row[cell..][..LANES])))
        });
        for j in 0..REACH {
            let values = spread(columns.map(|column| column[j]));
            for i in 0..REACH {
                values[i].store_slice(&mut out[REACH * j + i][tile][first..][..LANES]);
            }
        }
    }
}

/// One point of [`TILES`] tiles: sums over the inputs.
#[inline(always)]
fn multiply<S: Simd>(simd: S, kernels: &[f32], spread: &[[f32; MOST_INPUTS]; TILES], out: &mut [[f32; LANES]; TILES]) {
    let inputs = kernels.len() / LANES;
    let [a, b, c, d, e, f]: [&[[f32; PAIR]]; TILES] = std::array::from_fn(|tile| spread[tile][..inputs].as_chunks().0);
    let zero = f32x16::splat(simd, 0.0);
    let [mut sum_a, mut sum_b, mut sum_c, mut sum_d, mut sum_e, mut sum_f] = [zero; TILES];
    for (pair, kernels) in kernels.as_chunks::<{ PAIR * LANES }>().0.iter().enumerate() {
        let (even, odd) = kernels.split_at(LANES);
        let even = f32x16::from_slice(simd, even);
        sum_a = even.mul_add(f32x16::splat(simd, a[pair][0]), sum_a);
        sum_b = even.mul_add(f32x16::splat(simd, b[pair][0]), sum_b);
        sum_c = even.mul_add(f32x16::splat(simd, c[pair][0]), sum_c);
        sum_d = even.mul_add(f32x16::splat(simd, d[pair][0]), sum_d);
        sum_e = even.mul_add(f32x16::splat(simd, e[pair][0]), sum_e);
        sum_f = even.mul_add(f32x16::splat(simd, f[pair][0]), sum_f);
        let odd = f32x16::from_slice(simd, odd);
        sum_a = odd.mul_add(f32x16::splat(simd, a[pair][1]), sum_a);
        sum_b = odd.mul_add(f32x16::splat(simd, b[pair][1]), sum_b);
        sum_c = odd.mul_add(f32x16::splat(simd, c[pair][1]), sum_c);
        sum_d = odd.mul_add(f32x16::splat(simd, d[pair][1]), sum_d);
        sum_e = odd.mul_add(f32x16::splat(simd, e[pair][1]), sum_e);
        sum_f = odd.mul_add(f32x16::splat(simd, f[pair][1]), sum_f);
    }
    for (out, sums) in out.iter_mut().zip([sum_a, sum_b, sum_c, sum_d, sum_e, sum_f]) {
        sums.store_array(out);
    }
}

/// `Aᵀ m A` and the bias: the four cells of a tile, row by row.
#[inline(always)]
fn gather_tile<S: Simd>(
    simd: S,
    sums: &[[[f32; LANES]; TILES]; POINTS],
    tile: usize,
    bias: &[f32; LANES],
) -> [f32x16<S>; TILE * TILE] {
    let at = |i: usize, j: usize| f32x16::from_slice(simd, &sums[REACH * j + i][tile]);
    let columns: [_; REACH] = std::array::from_fn(|i| gather(std::array::from_fn(|j| at(i, j))));
    let bias = f32x16::from_slice(simd, bias);
    let mut cells = [bias; TILE * TILE];
    for j in 0..TILE {
        for (i, value) in gather(columns.map(|column| column[j])).into_iter().enumerate() {
            cells[TILE * j + i] += value;
        }
    }
    cells
}

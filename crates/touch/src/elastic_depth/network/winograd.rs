//! Convolutions of 3×3 cells with fewer products: the minimal filtering F(2×2, 3×3) of [Lavin2016].
//!
//! Tiles of 2×2 cells are computed from 4×4 inputs `d` and a kernel `g` as `Aᵀ [(G g Gᵀ) ∘ (Bᵀ d B)] A`, summed over the
//! inputs between the brackets. A cell takes 4 products for each input and output in place of 9.

use fearless_simd::{Simd, f32x16, prelude::*};
use fearless_simd_macros::simd;
use std::ops::Range;

use super::plane::Plane;
use super::shape::{LANES, Shape, TILE};

/// Inputs along a tile.
const REACH: usize = 4;
/// Products of a tile for each input and output.
const POINTS: usize = REACH * REACH;
/// Tiles computed together: they share the weights that they read, and their sums fill the registers of AVX2.
const TILES: usize = 6;
/// Largest number of input channels; the transformed inputs of [`TILES`] tiles then fit into the first cache.
const MOST_INPUTS: usize = 64;

/// Whether this method can be used for a layer: the inputs of a cell fill whole registers.
pub(super) fn applies(shape: Shape) -> bool {
    shape.side == 3 && shape.stride == 1 && (LANES..=MOST_INPUTS).contains(&shape.inputs)
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

/// Applies a layer with these kernels and biases to the cells of some rows: passes the block of outputs, the column, the row
/// and the sums of each cell to `finish`.
#[simd]
#[expect(clippy::large_stack_arrays, reason = "memory of a layer; nothing is allocated for a frame")]
pub(super) fn run<S: Simd>(
    simd: S,
    (kernels, biases): (&[f32], &[f32]),
    from: &Plane,
    (columns, rows): (usize, Range<usize>),
    mut finish: impl FnMut((usize, usize, usize), &[f32; LANES]),
) {
    let inputs = from.channels;
    let mut memory = [0.0; POINTS * TILES * MOST_INPUTS];
    let mut sums = [[[0.0; LANES]; TILES]; POINTS];
    let spread = &mut memory[..POINTS * TILES * inputs];
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
            spread_tile(simd, from, place, tile, spread);
        }
        let blocks = kernels.chunks_exact(POINTS * inputs * LANES).zip(biases.as_chunks::<LANES>().0);
        for (block, (kernels, bias)) in blocks.enumerate() {
            let points = kernels.chunks_exact(inputs * LANES).zip(spread.chunks_exact(TILES * inputs));
            for (sums, (kernels, spread)) in sums.iter_mut().zip(points) {
                multiply(simd, kernels, spread, sums);
            }
            for (tile, (column, row)) in places.into_iter().enumerate() {
                let cells = gather_tile(simd, &sums, tile, bias);
                for (at, sums) in cells.iter().enumerate() {
                    let (column, row) = (column + at % TILE, row + at / TILE);
                    if column < columns && row < rows.end {
                        finish((block, column, row), sums);
                    }
                }
            }
        }
    }
}

/// `Bᵀ d B` of a tile whose upper left cell is at `(column, row)`, for all inputs; `out` is `[point][tile][input]`.
#[inline(always)]
fn spread_tile<S: Simd>(simd: S, from: &Plane, (column, row): (usize, usize), tile: usize, out: &mut [f32]) {
    let inputs = from.channels;
    let start = row * from.stride() + column * inputs;
    let rows: [_; REACH] = std::array::from_fn(|j| &from.values()[start + j * from.stride()..][..REACH * inputs]);
    for first in (0..inputs).step_by(LANES) {
        // The last inputs overlap the previous ones.
        let first = first.min(inputs - LANES);
        let columns: [_; REACH] = std::array::from_fn(|i| {
            let cell = i * inputs + first;
            spread(rows.map(|row| f32x16::from_slice(simd, &row[cell..][..LANES])))
        });
        let mut points = out.chunks_exact_mut(TILES * inputs);
        for j in 0..REACH {
            for value in spread(columns.map(|column| column[j])) {
                let Some(point) = points.next() else { return };
                value.store_slice(&mut point[tile * inputs + first..][..LANES]);
            }
        }
    }
}

/// One point of [`TILES`] tiles: sums over the inputs.
#[inline(always)]
fn multiply<S: Simd>(simd: S, kernels: &[f32], spread: &[f32], out: &mut [[f32; LANES]; TILES]) {
    let inputs = spread.len() / TILES;
    let [a, b, c, d, e, f]: [&[f32]; TILES] = std::array::from_fn(|tile| &spread[tile * inputs..][..inputs]);
    let zero = f32x16::splat(simd, 0.0);
    let [mut sum_a, mut sum_b, mut sum_c, mut sum_d, mut sum_e, mut sum_f] = [zero; TILES];
    for (input, kernels) in kernels.as_chunks::<LANES>().0.iter().enumerate() {
        let kernels = f32x16::from_slice(simd, kernels);
        sum_a = kernels.mul_add(f32x16::splat(simd, a[input]), sum_a);
        sum_b = kernels.mul_add(f32x16::splat(simd, b[input]), sum_b);
        sum_c = kernels.mul_add(f32x16::splat(simd, c[input]), sum_c);
        sum_d = kernels.mul_add(f32x16::splat(simd, d[input]), sum_d);
        sum_e = kernels.mul_add(f32x16::splat(simd, e[input]), sum_e);
        sum_f = kernels.mul_add(f32x16::splat(simd, f[input]), sum_f);
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
) -> [[f32; LANES]; TILE * TILE] {
    let at = |i: usize, j: usize| f32x16::from_slice(simd, &sums[REACH * j + i][tile]);
    let columns: [_; REACH] = std::array::from_fn(|i| gather(std::array::from_fn(|j| at(i, j))));
    let bias = f32x16::from_slice(simd, bias);
    let mut cells = [[0.0; LANES]; TILE * TILE];
    for j in 0..TILE {
        for (i, value) in gather(columns.map(|column| column[j])).into_iter().enumerate() {
            (value + bias).store_array(&mut cells[TILE * j + i]);
        }
    }
    cells
}

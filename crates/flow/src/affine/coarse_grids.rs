//! Corrections on coarser grids, so that the coupled system converges in a few steps.
//!
//! The coupling between neighbours is much stiffer than a patch's own equations. If the preconditioner consists only of
//! the nodes' own blocks, a smooth motion needs many conjugate-gradient steps, because each step propagates it by one
//! node. Coarser grids correct it in one step. Every `spacing`-th node has a coarse node with a value and two slopes
//! for each component. The fine field is their Hermite interpolant, which represents any affine motion exactly. The
//! residual is restricted to the coarse nodes, each coarse node is solved separately, and the corrections of all grids
//! are added: the multilevel preconditioner of [Bramble1990].
//!
//! With `t` the distance from a coarse node in spacings, `g₀, g₁` the Hermite functions of value and slope and `d₀, d₁`
//! their derivatives per fine node, a coarse node `(A, Aₓ, A_y)` gives at a fine one
//!
//! ```text
//! a   = g₀(x) g₀(y) A + g₁(x) g₀(y) Aₓ + g₀(x) g₁(y) A_y
//! aₓ  = d₀(x) g₀(y) A + d₁(x) g₀(y) Aₓ + d₀(x) g₁(y) A_y
//! a_y = g₀(x) d₀(y) A + g₁(x) d₀(y) Aₓ + g₀(x) d₁(y) A_y
//! ```

mod blocks;

use super::bonds::Stiffness;
use super::grid::PatchGrid;
use super::nodes::{Planes, UNKNOWNS};
use super::symmetric::{PACKED, packed};
use crate::multiply_add::multiply_add;
use fearless_simd::Simd;
use fearless_simd_macros::simd;

/// Distance between the coarse nodes of each grid, in fine nodes; twice this is a multiple of eight, see [`dots`].
const SPACINGS: [usize; 2] = [4, 16];

/// Inverse blocks of the coarse nodes, packed, for each grid.
pub(crate) type CoarseBlocks = Vec<Vec<[f32; PACKED]>>;

/// The coarser grids of a patch grid and their scratch memory.
#[derive(Debug, Clone)]
pub(crate) struct CoarseGrids {
    grids: Vec<CoarseGrid>,
}

#[derive(Debug, Clone)]
struct CoarseGrid {
    fine: PatchGrid,
    spacing: usize,
    columns: usize,
    rows: usize,
    /// Basis at every offset from −spacing to spacing.
    basis: Vec<Basis>,
    /// `g₀`, `g₁`, `d₀`, `d₁` at every offset from −spacing to below spacing.
    tables: [Vec<f32>; 4],
    /// Restricted along the columns: for a component and a coarse row `Σ g₀ r + d₀ r_y`, `Σ g₀ r_x`, `Σ g₁ r + d₁ r_y`,
    /// `Σ g₁ r_x`, for each fine column. A row begins a spacing before the first column and ends a spacing after the last
    /// coarse one, so that the support of every coarse node is complete.
    lines: [Vec<f32>; 8],
    /// Residual, then correction, of the coarse nodes.
    nodes: Vec<[f32; UNKNOWNS]>,
}

/// Hermite functions of value and slope at an offset, and their derivatives per fine node.
#[derive(Debug, Clone, Copy)]
struct Basis {
    g0: f32,
    g1: f32,
    d0: f32,
    d1: f32,
}

impl Basis {
    /// At fine node `index` of `0..=2·spacing`; the coarse node is in the middle.
    fn at(index: usize, spacing: usize) -> Self {
        let s = spacing as f32;
        let signed = index as f32 / s - 1.0;
        let t = signed.abs();
        Self {
            g0: (1.0 + 2.0 * t) * (1.0 - t).powi(2),
            g1: s * signed * (1.0 - t).powi(2),
            d0: -6.0 * signed * (1.0 - t) / s,
            d1: (1.0 - t) * (1.0 - 3.0 * t),
        }
    }
}

impl CoarseGrids {
    pub(crate) fn new(fine: PatchGrid) -> Self {
        let fits = |spacing: &usize| fine.columns.min(fine.rows) > *spacing;
        Self { grids: SPACINGS.into_iter().filter(fits).map(|spacing| CoarseGrid::new(fine, spacing)).collect() }
    }

    /// Sets the inverse blocks for patches with these normal equations, if all patches are valid. Allocates only for a new
    /// template.
    pub(crate) fn set_blocks(
        &self,
        normal: &[Vec<f32>; PACKED],
        scale: f32,
        stiffness: Stiffness,
        blocks: &mut CoarseBlocks,
    ) {
        blocks.resize_with(self.grids.len(), Vec::new);
        for (grid, blocks) in self.grids.iter().zip(blocks) {
            blocks.clear();
            blocks.extend(grid.blocks(normal, scale, stiffness));
        }
    }

    /// Adds the corrections for a residual.
    #[simd]
    pub(crate) fn correct<S: Simd>(
        &mut self,
        simd: S,
        blocks: &CoarseBlocks,
        residual: &Planes,
        correction: &mut Planes,
    ) {
        for (grid, blocks) in self.grids.iter_mut().zip(blocks) {
            grid.restrict(simd, residual);
            for (node, block) in grid.nodes.iter_mut().zip(blocks) {
                let right = *node;
                *node = std::array::from_fn(|i| (0..UNKNOWNS).map(|j| block[packed(i, j)] * right[j]).sum());
            }
            grid.prolong(simd, correction);
        }
    }
}

impl CoarseGrid {
    fn new(fine: PatchGrid, spacing: usize) -> Self {
        let count = |nodes: usize| (nodes - 1).div_ceil(spacing) + 1;
        let (columns, rows) = (count(fine.columns), count(fine.rows));
        let basis: Vec<_> = (0..=2 * spacing).map(|index| Basis::at(index, spacing)).collect();
        let table = |of: fn(&Basis) -> f32| basis[..2 * spacing].iter().map(of).collect();
        Self {
            fine,
            spacing,
            columns,
            rows,
            tables: [table(|b| b.g0), table(|b| b.g1), table(|b| b.d0), table(|b| b.d1)],
            basis,
            lines: std::array::from_fn(|_| vec![0.0; rows * (columns + 1) * spacing]),
            nodes: vec![[0.0; UNKNOWNS]; columns * rows],
        }
    }

    /// Values in a row of `lines`.
    #[inline(always)]
    fn line_len(&self) -> usize {
        (self.columns + 1) * self.spacing
    }

    /// The basis of coarse node `coarse` at fine node `fine` along an axis, which lie at most a spacing apart.
    #[inline(always)]
    fn basis(&self, fine: usize, coarse: usize) -> Basis {
        self.basis[fine + self.spacing - coarse * self.spacing]
    }

    /// The range of fine nodes along an axis that a coarse node affects.
    #[inline(always)]
    fn support(&self, coarse: usize, count: usize) -> std::ops::Range<usize> {
        let centre = coarse * self.spacing;
        (centre + 1).saturating_sub(self.spacing)..(centre + self.spacing).min(count)
    }

    /// The coarse nodes on both sides of a fine one; only one if the fine node coincides with it.
    #[inline(always)]
    fn beside(&self, fine: usize) -> std::ops::RangeInclusive<usize> {
        fine / self.spacing..=fine.div_ceil(self.spacing)
    }

    /// Restricts a residual to the coarse nodes: along the columns first, so that whole rows are processed at once.
    #[simd]
    fn restrict<S: Simd>(&mut self, simd: S, residual: &Planes) {
        let (columns, stride) = (self.fine.columns, self.line_len());
        self.lines.iter_mut().for_each(|line| line.fill(0.0));
        for fine_row in 0..self.fine.rows {
            for row in self.beside(fine_row) {
                let basis = self.basis(fine_row, row);
                for component in 0..2 {
                    let [value, slope_x, slope_y] = part(residual, component, fine_row * columns, columns);
                    let start = row * stride + self.spacing;
                    let [u0, v0, u1, v1] = parts_mut(&mut self.lines, component, start, columns);
                    for i in 0..columns {
                        u0[i] = multiply_add(simd, basis.g0, value[i], multiply_add(simd, basis.d0, slope_y[i], u0[i]));
                        v0[i] = multiply_add(simd, basis.g0, slope_x[i], v0[i]);
                        u1[i] = multiply_add(simd, basis.g1, value[i], multiply_add(simd, basis.d1, slope_y[i], u1[i]));
                        v1[i] = multiply_add(simd, basis.g1, slope_x[i], v1[i]);
                    }
                }
            }
        }
        let support = 2 * self.spacing;
        let [g0, g1, d0, d1] = self.tables.each_ref().map(|table| &table[..support]);
        for row in 0..self.rows {
            for column in 0..self.columns {
                let start = row * stride + column * self.spacing;
                let node = &mut self.nodes[row * self.columns + column];
                for component in 0..2 {
                    let [u0, v0, u1, v1] = parts(&self.lines, component, start, support);
                    node[3 * component] = dots(simd, g0, u0, d0, v0);
                    node[3 * component + 1] = dots(simd, g1, u0, d1, v0);
                    node[3 * component + 2] = dots(simd, g0, u1, d0, v1);
                }
            }
        }
    }

    /// Adds the interpolant of the coarse nodes: along the coarse rows first.
    #[simd]
    fn prolong<S: Simd>(&mut self, simd: S, field: &mut Planes) {
        self.interpolate_rows();
        let (columns, stride) = (self.fine.columns, self.line_len());
        for fine_row in 0..self.fine.rows {
            for row in self.beside(fine_row) {
                let basis = self.basis(fine_row, row);
                for component in 0..2 {
                    let [u0, v0, u1, v1] = parts(&self.lines, component, row * stride + self.spacing, columns);
                    let [value, slope_x, slope_y] = part_mut(field, component, fine_row * columns, columns);
                    for i in 0..columns {
                        value[i] = multiply_add(simd, basis.g0, u0[i], multiply_add(simd, basis.g1, u1[i], value[i]));
                        slope_x[i] =
                            multiply_add(simd, basis.g0, v0[i], multiply_add(simd, basis.g1, v1[i], slope_x[i]));
                        slope_y[i] =
                            multiply_add(simd, basis.d0, u0[i], multiply_add(simd, basis.d1, u1[i], slope_y[i]));
                    }
                }
            }
        }
    }

    /// Interpolates along the coarse rows, from one coarse node to the next.
    #[inline(always)]
    fn interpolate_rows(&mut self) {
        let (spacing, stride) = (self.spacing, self.line_len());
        // To the right of a coarse node the second half of its basis counts, and the first half of its neighbour's.
        let [[g0, h0], [g1, h1], [d0, e0], [d1, e1]] = self.tables.each_ref().map(|table| {
            let (before, after) = table.split_at(spacing);
            [after, before]
        });
        for row in 0..self.rows {
            for column in 0..self.columns {
                let here = self.nodes[row * self.columns + column];
                let is_last = column + 1 == self.columns;
                let next = if is_last { [0.0; UNKNOWNS] } else { self.nodes[row * self.columns + column + 1] };
                for component in 0..2 {
                    let [a, ax, ay] = [0, 1, 2].map(|k| here[3 * component + k]);
                    let [b, bx, by] = [0, 1, 2].map(|k| next[3 * component + k]);
                    let start = row * stride + (column + 1) * spacing;
                    let [u0, v0, u1, v1] = parts_mut(&mut self.lines, component, start, spacing);
                    for k in 0..spacing {
                        u0[k] = (g0[k] * a + g1[k] * ax) + (h0[k] * b + h1[k] * bx);
                        v0[k] = (d0[k] * a + d1[k] * ax) + (e0[k] * b + e1[k] * bx);
                        u1[k] = g0[k] * ay + h0[k] * by;
                        v1[k] = d0[k] * ay + e0[k] * by;
                    }
                }
            }
        }
    }
}

/// `Σ a x + b y`, in eight parts that are summed at the end, so that the sum is vectorised.
#[inline(always)]
fn dots<S: Simd>(simd: S, a: &[f32], x: &[f32], b: &[f32], y: &[f32]) -> f32 {
    const PARTS: usize = 8;
    let mut sums = [0.0; PARTS];
    let [(a, _), (x, _), (b, _), (y, _)] = [a, x, b, y].map(<[f32]>::as_chunks::<PARTS>);
    for ((a, x), (b, y)) in a.iter().zip(x).zip(b.iter().zip(y)) {
        for k in 0..PARTS {
            sums[k] = multiply_add(simd, a[k], x[k], multiply_add(simd, b[k], y[k], sums[k]));
        }
    }
    sums.iter().sum()
}

#[inline(always)]
fn part(planes: &Planes, component: usize, start: usize, len: usize) -> [&[f32]; 3] {
    std::array::from_fn(|k| &planes[3 * component + k][start..][..len])
}

#[inline(always)]
fn part_mut(planes: &mut Planes, component: usize, start: usize, len: usize) -> [&mut [f32]; 3] {
    let own: &mut [Vec<f32>; 3] = planes[3 * component..].first_chunk_mut().expect("three planes of one component");
    own.each_mut().map(|plane| &mut plane[start..][..len])
}

#[inline(always)]
fn parts(lines: &[Vec<f32>; 8], component: usize, start: usize, len: usize) -> [&[f32]; 4] {
    std::array::from_fn(|k| &lines[4 * component + k][start..][..len])
}

#[inline(always)]
fn parts_mut(lines: &mut [Vec<f32>; 8], component: usize, start: usize, len: usize) -> [&mut [f32]; 4] {
    let own: &mut [Vec<f32>; 4] = lines[4 * component..].first_chunk_mut().expect("four lines of one component");
    own.each_mut().map(|line| &mut line[start..][..len])
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    const GRID: PatchGrid = PatchGrid { width: 200, height: 152, columns: 25, rows: 19 };

    fn planes(of: impl Fn(usize, usize, usize) -> f32) -> Planes {
        std::array::from_fn(|k| {
            let mut plane = vec![0.0; GRID.plane_len()];
            (0..GRID.nodes()).for_each(|node| plane[node] = of(k, node % GRID.columns, node / GRID.columns));
            plane
        })
    }

    fn noise(seed: usize) -> f32 {
        ((seed.wrapping_mul(2_654_435_761) >> 7) % 2001) as f32 / 1000.0 - 1.0
    }

    #[test]
    fn an_affine_motion_is_interpolated_without_error() {
        for spacing in SPACINGS {
            let mut grid = CoarseGrid::new(GRID, spacing);
            let affine = |component: usize, x: f32, y: f32| {
                let [a, b, c] = [[1.0, 0.3, -0.2], [-2.0, 0.1, 0.4]][component];
                [a + b * x + c * y, b, c]
            };
            for node in 0..grid.nodes.len() {
                let (x, y) = (node % grid.columns * spacing, node / grid.columns * spacing);
                grid.nodes[node] = std::array::from_fn(|k| affine(k / 3, x as f32, y as f32)[k % 3]);
            }
            let mut field = planes(|_, _, _| 0.0);
            dispatch!(Level::new(), simd => grid.prolong(simd, &mut field));
            let expected = planes(|k, x, y| affine(k / 3, x as f32, y as f32)[k % 3]);
            for (field, expected) in field.iter().zip(&expected) {
                let largest = field.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                assert!(largest < 1e-4, "spacing {spacing}: off by {largest}");
            }
        }
    }

    #[test]
    fn restriction_is_the_transpose_of_interpolation() {
        for spacing in SPACINGS {
            let mut grid = CoarseGrid::new(GRID, spacing);
            let residual = planes(|k, x, y| noise(7 * k + 101 * x + 1009 * y));
            let coarse: Vec<[f32; UNKNOWNS]> =
                (0..grid.nodes.len()).map(|node| std::array::from_fn(|k| noise(31 * k + 577 * node))).collect();
            grid.nodes.copy_from_slice(&coarse);
            let mut field = planes(|_, _, _| 0.0);
            dispatch!(Level::new(), simd => grid.prolong(simd, &mut field));
            dispatch!(Level::new(), simd => grid.restrict(simd, &residual));
            let product = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| f64::from(a * b)).sum::<f64>();
            let fine: f64 = field.iter().zip(&residual).map(|(a, b)| product(a, b)).sum();
            let coarse = product(grid.nodes.as_flattened(), coarse.as_flattened());
            assert!((fine - coarse).abs() < 1e-4 * fine.abs().max(1.0), "spacing {spacing}: {fine} and {coarse}");
        }
    }
}

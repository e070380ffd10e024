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

use super::bonds::Stiffness;
use super::grid::PatchGrid;
use super::nodes::{Planes, UNKNOWNS};
use super::symmetric::invert;
use super::symmetric::{PACKED, packed};
use fearless_simd::Simd;
use fearless_simd_macros::simd;

/// Distance between the coarse nodes of each grid, in fine nodes.
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
    /// Restricted along the columns: for a component and a coarse row `Σ g₀ r + d₀ r_y`, `Σ g₀ r_x`, `Σ g₁ r + d₁ r_y`,
    /// `Σ g₁ r_x`, for each fine column.
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

/// Contributions of a coarse node's value and slopes to value and slopes at a fine node.
fn shape(x: Basis, y: Basis) -> [[f64; 3]; 3] {
    let rows = [
        [x.g0 * y.g0, x.g1 * y.g0, x.g0 * y.g1],
        [x.d0 * y.g0, x.d1 * y.g0, x.d0 * y.g1],
        [x.g0 * y.d0, x.g1 * y.d0, x.g0 * y.d1],
    ];
    rows.map(|row| row.map(f64::from))
}

impl CoarseGrids {
    pub(crate) fn new(fine: PatchGrid) -> Self {
        let fits = |spacing: &usize| fine.columns.min(fine.rows) > *spacing;
        Self { grids: SPACINGS.into_iter().filter(fits).map(|spacing| CoarseGrid::new(fine, spacing)).collect() }
    }

    /// The inverse blocks for patches with these normal equations, if all patches are valid.
    pub(crate) fn blocks(&self, normal: &[Vec<f32>; PACKED], scale: f32, stiffness: Stiffness) -> CoarseBlocks {
        self.grids.iter().map(|grid| grid.blocks(normal, scale, stiffness)).collect()
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
        Self {
            fine,
            spacing,
            columns,
            rows,
            basis: (0..=2 * spacing).map(|index| Basis::at(index, spacing)).collect(),
            lines: std::array::from_fn(|_| vec![0.0; rows * fine.columns]),
            nodes: vec![[0.0; UNKNOWNS]; columns * rows],
        }
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

    fn blocks(&self, normal: &[Vec<f32>; PACKED], scale: f32, stiffness: Stiffness) -> Vec<[f32; PACKED]> {
        let bonds = self.bond_energy(stiffness);
        let nodes = (0..self.rows).flat_map(|row| (0..self.columns).map(move |column| (column, row)));
        nodes
            .map(|(column, row)| {
                let mut block = [[0.0; UNKNOWNS]; UNKNOWNS];
                for j in self.support(row, self.fine.rows) {
                    for i in self.support(column, self.fine.columns) {
                        let shape = shape(self.basis(i, column), self.basis(j, row));
                        add_normal(&mut block, normal, j * self.fine.columns + i, scale, shape);
                    }
                }
                for (i, row) in block.iter_mut().enumerate() {
                    for (j, entry) in row.iter_mut().enumerate().filter(|(j, _)| i / 3 == j / 3) {
                        *entry += bonds[i % 3][j % 3];
                    }
                    // Keeps the block of a coarse node without texture and bonds invertible.
                    row[i] += 1e-6;
                }
                let inverse = invert(block);
                let mut packed_inverse = [0.0; PACKED];
                for i in 0..UNKNOWNS {
                    for j in 0..=i {
                        packed_inverse[packed(i, j)] = inverse[i][j] as f32;
                    }
                }
                packed_inverse
            })
            .collect()
    }

    /// The energy of all pairs with bond 1 in the field of one coarse node, for one component.
    fn bond_energy(&self, stiffness: Stiffness) -> [[f64; 3]; 3] {
        let (continuity, curvature) = (f64::from(stiffness.continuity), f64::from(stiffness.curvature));
        // One node outside its range the field is zero.
        let at = |x: usize, y: usize| match (self.basis.get(x), self.basis.get(y)) {
            (Some(&x), Some(&y)) => shape(x, y),
            _ => [[0.0; 3]; 3],
        };
        let mut energy = [[0.0; 3]; 3];
        for y in 0..self.basis.len() {
            for x in 0..self.basis.len() {
                for (along, other) in [(1, at(x + 1, y)), (2, at(x, y + 1))] {
                    let here = at(x, y);
                    let terms = |k: usize| {
                        let mismatch = here[0][k] - other[0][k] + 0.5 * (here[along][k] + other[along][k]);
                        [mismatch, here[1][k] - other[1][k], here[2][k] - other[2][k]]
                    };
                    for (i, row) in energy.iter_mut().enumerate() {
                        for (j, entry) in row.iter_mut().enumerate() {
                            let ([c, px, py], [d, qx, qy]) = (terms(i), terms(j));
                            *entry += continuity * c * d + curvature * (px * qx + py * qy);
                        }
                    }
                }
            }
        }
        energy
    }

    /// Restricts a residual to the coarse nodes: along the columns first, so that whole rows are processed at once.
    #[simd]
    fn restrict<S: Simd>(&mut self, simd: S, residual: &Planes) {
        let _ = simd;
        let columns = self.fine.columns;
        self.lines.iter_mut().for_each(|line| line.fill(0.0));
        for fine_row in 0..self.fine.rows {
            for row in self.beside(fine_row) {
                let basis = self.basis(fine_row, row);
                for component in 0..2 {
                    let [value, slope_x, slope_y] = part(residual, component, fine_row * columns, columns);
                    let [u0, v0, u1, v1] = parts_mut(&mut self.lines, component, row * columns, columns);
                    for i in 0..columns {
                        u0[i] += basis.g0 * value[i] + basis.d0 * slope_y[i];
                        v0[i] += basis.g0 * slope_x[i];
                        u1[i] += basis.g1 * value[i] + basis.d1 * slope_y[i];
                        v1[i] += basis.g1 * slope_x[i];
                    }
                }
            }
        }
        for row in 0..self.rows {
            for column in 0..self.columns {
                let mut sums = [0.0; UNKNOWNS];
                for i in self.support(column, columns) {
                    let basis = self.basis(i, column);
                    for component in 0..2 {
                        let [u0, v0, u1, v1] = [0, 1, 2, 3].map(|k| self.lines[4 * component + k][row * columns + i]);
                        sums[3 * component] += basis.g0 * u0 + basis.d0 * v0;
                        sums[3 * component + 1] += basis.g1 * u0 + basis.d1 * v0;
                        sums[3 * component + 2] += basis.g0 * u1 + basis.d0 * v1;
                    }
                }
                self.nodes[row * self.columns + column] = sums;
            }
        }
    }

    /// Adds the interpolant of the coarse nodes: along the coarse rows first.
    #[simd]
    fn prolong<S: Simd>(&mut self, simd: S, field: &mut Planes) {
        let _ = simd;
        let columns = self.fine.columns;
        self.lines.iter_mut().for_each(|line| line.fill(0.0));
        for row in 0..self.rows {
            for i in 0..columns {
                for column in self.beside(i) {
                    let basis = self.basis(i, column);
                    let node = &self.nodes[row * self.columns + column];
                    for component in 0..2 {
                        let [value, slope_x, slope_y] = [0, 1, 2].map(|k| node[3 * component + k]);
                        let at = row * columns + i;
                        self.lines[4 * component][at] += basis.g0 * value + basis.g1 * slope_x;
                        self.lines[4 * component + 1][at] += basis.d0 * value + basis.d1 * slope_x;
                        self.lines[4 * component + 2][at] += basis.g0 * slope_y;
                        self.lines[4 * component + 3][at] += basis.d0 * slope_y;
                    }
                }
            }
        }
        for fine_row in 0..self.fine.rows {
            for row in self.beside(fine_row) {
                let basis = self.basis(fine_row, row);
                for component in 0..2 {
                    let [u0, v0, u1, v1] = parts(&self.lines, component, row * columns, columns);
                    let [value, slope_x, slope_y] = part_mut(field, component, fine_row * columns, columns);
                    for i in 0..columns {
                        value[i] += basis.g0 * u0[i] + basis.g1 * u1[i];
                        slope_x[i] += basis.g0 * v0[i] + basis.g1 * v1[i];
                        slope_y[i] += basis.d0 * u0[i] + basis.d1 * u1[i];
                    }
                }
            }
        }
    }
}

/// Adds `Bᵀ N B` of a fine node to a coarse node's block.
fn add_normal(
    block: &mut [[f64; UNKNOWNS]; UNKNOWNS],
    normal: &[Vec<f32>; PACKED],
    node: usize,
    scale: f32,
    shape: [[f64; 3]; 3],
) {
    for (i, row) in block.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            let mut sum = 0.0;
            for (p, of_i) in shape.iter().enumerate() {
                for (q, of_j) in shape.iter().enumerate() {
                    let n = f64::from(normal[packed(3 * (i / 3) + p, 3 * (j / 3) + q)][node]);
                    sum += of_i[i % 3] * n * of_j[j % 3];
                }
            }
            *entry += f64::from(scale) * sum;
        }
    }
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

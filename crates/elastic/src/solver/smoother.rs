//! Gauss–Seidel, slab by slab: the even slabs together, then the odd ones, node after node within a slab.
//!
//! A slab depends only on itself and its two neighbours, so slabs of one parity can be smoothed in parallel and the
//! result does not depend on the number of threads. A backward sweep is the transpose of a forward one, which keeps a
//! cycle symmetric.

use super::stencil::{Rows, row_product};
use super::{Grid, Stencil};
use fearless_simd::{Simd, dispatch};
use rayon::prelude::*;

/// The order in which the nodes are visited.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sweep {
    Forward,
    Backward,
}

/// Smooths with one matrix; created again when the matrix changes.
#[derive(Debug, Clone)]
pub(super) struct Smoother {
    inverse_blocks: Vec<[[f32; 3]; 3]>,
    next: Vec<[f32; 3]>,
}

impl Smoother {
    pub(super) fn new(grid: Grid) -> Self {
        Self { inverse_blocks: vec![[[0.0; 3]; 3]; grid.len()], next: vec![[0.0; 3]; grid.len()] }
    }

    /// Inverts the nodes' own blocks.
    pub(super) fn refresh(&mut self, matrix: &Stencil) {
        let (grid, slab) = (matrix.grid, matrix.grid.slab());
        let slabs = self.inverse_blocks[slab..].par_chunks_mut(slab).take(grid.nodes[1]).enumerate();
        slabs.with_min_len(grid.least_slabs()).for_each(|(j, inverses)| {
            for place in grid.slab_nodes() {
                inverses[place] = inverse(matrix.own_block((j + 1) * slab + place));
            }
        });
    }

    /// One sweep towards `matrix · field = right`.
    pub(super) fn sweep(&mut self, matrix: &Stencil, right: &[[f32; 3]], field: &mut [[f32; 3]], sweep: Sweep) {
        let parities = if sweep == Sweep::Forward { [0, 1] } else { [1, 0] };
        for parity in parities {
            self.smooth_slabs(matrix, right, field, (parity, sweep));
            let slab = matrix.grid.slab();
            let own = |j: usize| j < matrix.grid.nodes[1] && j % 2 == parity;
            for j in (0..matrix.grid.nodes[1]).filter(|&j| own(j)) {
                let range = (j + 1) * slab..(j + 2) * slab;
                field[range.clone()].copy_from_slice(&self.next[range]);
            }
        }
    }

    fn smooth_slabs(
        &mut self,
        matrix: &Stencil,
        right: &[[f32; 3]],
        field: &[[f32; 3]],
        (parity, sweep): (usize, Sweep),
    ) {
        let (grid, slab) = (matrix.grid, matrix.grid.slab());
        let inverses = &self.inverse_blocks;
        let slabs = self.next[slab..].par_chunks_mut(slab).take(grid.nodes[1]).enumerate();
        slabs.with_min_len(2 * grid.least_slabs()).filter(|(j, _)| j % 2 == parity).for_each(|(j, next)| {
            let start = (j + 1) * slab;
            next.copy_from_slice(&field[start..start + slab]);
            let slab = Slab {
                grid,
                rows: &matrix.rows[start..start + slab],
                inverses: &inverses[start..start + slab],
                right: &right[start..start + slab],
                beside: [&field[start - slab..start], &field[start + slab..][..slab]],
            };
            dispatch!(matrix.simd, simd => match sweep {
                Sweep::Forward => slab.visit(simd, grid.slab_nodes(), next),
                Sweep::Backward => slab.visit(simd, grid.slab_nodes().rev(), next),
            });
        });
    }
}

/// The inputs of smoothing a slab.
struct Slab<'a> {
    grid: Grid,
    rows: &'a [Rows],
    inverses: &'a [[[f32; 3]; 3]],
    right: &'a [[f32; 3]],
    /// The slabs before it and after it.
    beside: [&'a [[f32; 3]]; 2],
}

impl Slab<'_> {
    /// Solves for one node of the slab's own field after the other.
    #[inline(always)]
    fn visit<S: Simd>(&self, simd: S, places: impl Iterator<Item = usize>, own: &mut [[f32; 3]]) {
        for place in places {
            let product =
                row_product(simd, &self.rows[place], [self.beside[0], own, self.beside[1]], self.grid.row(), place);
            let rest = [0, 1, 2].map(|c| self.right[place][c] - product[c]);
            let step = self.inverses[place].map(|row| row[0] * rest[0] + row[1] * rest[1] + row[2] * rest[2]);
            own[place] = [0, 1, 2].map(|c| own[place][c] + step[c]);
        }
    }
}

/// Inverse of a 3×3 block; zero if it has none, which leaves the node unchanged.
fn inverse(a: [[f32; 3]; 3]) -> [[f32; 3]; 3] {
    let a = a.map(|row| row.map(f64::from));
    let minor = |r: usize, c: usize| {
        let (r1, r2, c1, c2) = ((r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3);
        a[r1][c1] * a[r2][c2] - a[r1][c2] * a[r2][c1]
    };
    let determinant: f64 = (0..3).map(|c| a[0][c] * minor(0, c)).sum();
    let scale = a.iter().flatten().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    if determinant.abs() <= 1e-9 * scale.powi(3) {
        return [[0.0; 3]; 3];
    }
    [0, 1, 2].map(|r| [0, 1, 2].map(|c| (minor(c, r) / determinant) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_inverse_undoes_its_block() {
        let a = [[4.0, 1.0, 0.5], [1.0, 3.0, -0.2], [0.5, -0.2, 2.0]];
        let b = inverse(a);
        for (r, c) in (0..9).map(|n| (n / 3, n % 3)) {
            let product: f32 = (0..3).map(|k| a[r][k] * b[k][c]).sum();
            assert!((product - f32::from(u8::from(r == c))).abs() < 1e-6);
        }
        assert_eq!(inverse([[0.0; 3]; 3]).map(|row| row.map(f32::to_bits)), [[0; 3]; 3]);
    }
}

//! The blocks of the coarse nodes: the energy of the fine field that a coarse node gives, and its inverse.

use super::{Basis, CoarseGrid};
use crate::affine::bonds::Stiffness;
use crate::affine::nodes::UNKNOWNS;
use crate::affine::symmetric::{PACKED, invert, packed};

impl CoarseGrid {
    /// The inverse block of every node.
    pub(super) fn blocks(
        &self,
        normal: &[Vec<f32>; PACKED],
        scale: f32,
        stiffness: Stiffness,
    ) -> impl Iterator<Item = [f32; PACKED]> {
        let bonds = self.bond_energy(stiffness);
        let nodes = (0..self.rows).flat_map(|row| (0..self.columns).map(move |column| (column, row)));
        nodes.map(move |(column, row)| {
            let mut block = [[0.0; UNKNOWNS]; UNKNOWNS];
            for j in self.support(row, self.fine.rows) {
                for i in self.support(column, self.fine.columns) {
                    let shape = shape(self.basis(i, column), self.basis(j, row));
                    add_normal(&mut block, normal, j * self.fine.columns + i, scale, shape);
                }
            }
            for i in 0..3 {
                for j in 3..UNKNOWNS {
                    block[i][j] = block[j][i];
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

/// Adds `Bᵀ N B` of a fine node to the lower triangle of a coarse node's block. `B` is the same for both components.
fn add_normal(
    block: &mut [[f64; UNKNOWNS]; UNKNOWNS],
    normal: &[Vec<f32>; PACKED],
    node: usize,
    scale: f32,
    shape: [[f64; 3]; 3],
) {
    for (of_row, of_column) in [(0, 0), (3, 0), (3, 3)] {
        let entry = |p: usize, q: usize| f64::from(scale * normal[packed(of_row + p, of_column + q)][node]);
        let right: [[f64; 3]; 3] = std::array::from_fn(|p| {
            let row = [entry(p, 0), entry(p, 1), entry(p, 2)];
            std::array::from_fn(|j| row[0] * shape[0][j] + row[1] * shape[1][j] + row[2] * shape[2][j])
        });
        for i in 0..3 {
            for j in 0..3 {
                block[of_row + i][of_column + j] +=
                    shape[0][i] * right[0][j] + shape[1][i] * right[1][j] + shape[2][i] * right[2][j];
            }
        }
    }
}

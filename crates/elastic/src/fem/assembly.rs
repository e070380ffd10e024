//! From elements to the whole block: energy, nodal forces, tangent matrix.

use super::element::{self, Inverted, Nodes, Stiffness};
use super::{BlockMesh, Material};
use crate::solver::{Grid, Rows, Stencil, column};
use fearless_simd::{Level, dispatch};
use rayon::prelude::*;

/// The elements' energy and reaction at a displacement.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Assembled {
    /// Strain energy, N mm.
    pub(crate) energy: f64,
    /// Sum of the forces on the base, N.
    pub(crate) base_force: [f64; 3],
}

/// Assembles the elements of a mesh.
#[derive(Debug, Clone)]
pub(crate) struct Assembly {
    pub(crate) mesh: BlockMesh,
    pub(crate) material: Material,
    pub(crate) grid: Grid,
    simd: Level,
}

impl Assembly {
    pub(crate) fn new(mesh: BlockMesh, material: Material) -> Self {
        let grid = mesh.free_grid();
        Self { mesh, material, grid, simd: Level::new() }
    }

    /// Energy and nodal forces of a displacement (base nodes do not move).
    ///
    /// # Errors
    ///
    /// [`Inverted`] if an element is turned inside out; `forces` are then meaningless.
    pub(crate) fn forces_into(
        &self,
        displacement: &[[f64; 3]],
        forces: &mut [[f64; 3]],
    ) -> Result<Assembled, Inverted> {
        let slab = self.grid.slab();
        forces.fill([0.0; 3]);
        let mut parts = Vec::new();
        for parity in 0..2 {
            let part: Vec<_> = forces[(1 + parity) * slab..]
                .par_chunks_mut(2 * slab)
                .enumerate()
                .filter(|(pair, _)| 2 * pair + parity + 1 < self.grid.nodes[1])
                .map(|(pair, forces)| {
                    dispatch!(self.simd, _ => self.slab_forces(2 * pair + parity, displacement, forces))
                })
                .collect::<Result<_, _>>()?;
            parts.extend(part);
        }
        Ok(total(&parts))
    }

    /// The tangent matrix at a displacement.
    ///
    /// # Errors
    ///
    /// [`Inverted`] if an element is turned inside out; the matrix is then meaningless.
    pub(crate) fn tangent_into(&self, displacement: &[[f64; 3]], matrix: &mut Stencil) -> Result<(), Inverted> {
        let slab = self.grid.slab();
        matrix.rows.par_iter_mut().for_each(|rows| rows.as_flattened_mut().fill(0.0));
        (0..2).try_for_each(|parity| {
            matrix.rows[(1 + parity) * slab..]
                .par_chunks_mut(2 * slab)
                .enumerate()
                .filter(|(pair, _)| 2 * pair + parity + 1 < self.grid.nodes[1])
                .try_for_each(
                    |(pair, rows)| dispatch!(self.simd, _ => self.slab_rows(2 * pair + parity, displacement, rows)),
                )
        })
    }

    #[inline(always)]
    fn slab_rows(&self, j: usize, displacement: &[[f64; 3]], rows: &mut [Rows]) -> Result<(), Inverted> {
        let mut stiffness = [[[[0.0; 8]; 8]; 3]; 3];
        for (k, i) in self.cells_of_slab() {
            let (nodes, moved) = self.corners([i, j, k], displacement);
            element::stiffness(&nodes, &moved, &self.material, &mut stiffness)?;
            self.add_rows([i, k], &stiffness, rows);
        }
        Ok(())
    }

    #[inline(always)]
    fn slab_forces(&self, j: usize, displacement: &[[f64; 3]], forces: &mut [[f64; 3]]) -> Result<Assembled, Inverted> {
        let mut sum = Assembled::default();
        for (k, i) in self.cells_of_slab() {
            let (nodes, moved) = self.corners([i, j, k], displacement);
            let (energy, held) = element::evaluate(&nodes, &moved, &self.material)?;
            self.add_forces([i, k], &held, forces, &mut sum);
            sum.energy += energy;
        }
        Ok(sum)
    }

    fn cells_of_slab(&self) -> impl Iterator<Item = (usize, usize)> {
        let [columns, _, layers] = self.mesh.cells();
        (0..layers).flat_map(move |k| (0..columns).map(move |i| (k, i)))
    }

    /// Undeformed places and displacements of a cell's corners.
    #[inline(always)]
    fn corners(&self, [i, j, k]: [usize; 3], displacement: &[[f64; 3]]) -> (Nodes, Nodes) {
        let place = |node: usize| [i + (node & 1), j + (node >> 1 & 1), k + (node >> 2)];
        let nodes = std::array::from_fn(|node| {
            let [i, j, k] = place(node);
            self.mesh.node(i, j, k)
        });
        // The layer after the last free nodes is the base: it contains zeros.
        let moved = std::array::from_fn(|node| {
            let [i, j, k] = place(node);
            displacement[self.grid.index(i, j, k)]
        });
        (nodes, moved)
    }

    /// Adds a cell's forces to a pair of slabs, or to the base's sum.
    #[inline(always)]
    fn add_forces(&self, [i, k]: [usize; 2], held: &Nodes, forces: &mut [[f64; 3]], sum: &mut Assembled) {
        for (node, held) in held.iter().enumerate() {
            let layer = k + (node >> 2);
            let target = if layer == self.grid.nodes[2] {
                &mut sum.base_force
            } else {
                &mut forces[(node >> 1 & 1) * self.grid.slab() + self.grid.in_slab(i + (node & 1), layer)]
            };
            for (target, held) in target.iter_mut().zip(held) {
                *target += held;
            }
        }
    }

    #[inline(always)]
    fn add_rows(&self, [i, k]: [usize; 2], stiffness: &Stiffness, rows: &mut [Rows]) {
        let bits = |node: usize| [node & 1, node >> 1 & 1, node >> 2];
        for a in (0..8).filter(|a| k + (a >> 2) < self.grid.nodes[2]) {
            let [dx, dy, dz] = bits(a);
            let target = &mut rows[dy * self.grid.slab() + self.grid.in_slab(i + dx, k + dz)];
            for b in (0..8).filter(|b| k + (b >> 2) < self.grid.nodes[2]) {
                let (from, to) = (bits(a), bits(b));
                let first = column([0, 1, 2].map(|axis| to[axis].cast_signed() - from[axis].cast_signed()));
                for (r, c) in (0..9).map(|n| (n / 3, n % 3)) {
                    target[r][first + c] += stiffness[r][c][a][b] as f32;
                }
            }
        }
    }
}

fn total(parts: &[Assembled]) -> Assembled {
    parts.iter().fold(Assembled::default(), |sum, part| Assembled {
        energy: sum.energy + part.energy,
        base_force: [0, 1, 2].map(|c| sum.base_force[c] + part.base_force[c]),
    })
}

//! Couples fine patches with their neighbours and solves for their steps.
//!
//! The energy is that of the coarse patches ([`crate::affine::coupling`]), with half the stride. Nodes that are not
//! refined keep the coarse field. The refined nodes lie in narrow bands along rims, so Gauss–Seidel sweeps converge
//! quickly.

use super::grid::FineGrid;
use super::node::{FineNode, Motion, factor, substitute};
use crate::affine::bonds::Stiffness;
use crate::affine::nodes::UNKNOWNS;
use crate::affine::symmetric::{PACKED, packed};
use crate::affine::template::PatchEquations;

/// Index of a node that is not refined.
pub(super) const NONE: u32 = u32::MAX;

/// A neighbour: offset of its index, which slope is the one along the pair, and 1 if it comes after the node, −1 if
/// before.
type Side = (isize, usize, f32);

/// The coupled system of the refined nodes.
pub(super) struct Relaxation<'a> {
    /// The equations of every node of the grid.
    pub(super) equations: &'a [PatchEquations],
    pub(super) grid: FineGrid,
    pub(super) stiffness: Stiffness,
    /// Factor on the patches' equations: one over the noise variance and their overlap.
    pub(super) scale: f32,
    /// The field before the step, at all nodes near refined ones.
    pub(super) field: &'a [Motion],
    /// For every node of the grid its index among the refined ones, or [`NONE`].
    pub(super) index: &'a [u32],
}

impl Relaxation<'_> {
    /// Sweeps over all nodes, forwards and backwards.
    pub(super) fn run(&self, nodes: &mut [FineNode], sweeps: usize) {
        for node in nodes.iter_mut() {
            self.prepare(node);
        }
        for sweep in 0..sweeps {
            for k in 0..nodes.len() {
                let k = if sweep % 2 == 0 { k } else { nodes.len() - 1 - k };
                self.relax(nodes, k);
            }
        }
    }

    /// Computes the bonds of a node from the field, and factors its block.
    fn prepare(&self, node: &mut FineNode) {
        node.step = [0.0; UNKNOWNS];
        let tolerance = self.stiffness.tolerance;
        let roughness = self.sides().map(|side| self.roughness(node.place, side));
        node.roughness = 0.25 * roughness.iter().sum::<f32>();
        node.bonds = roughness.map(|roughness| tolerance / (tolerance + roughness));
        let mut matrix = [0.0; PACKED];
        if node.is_trusted {
            matrix = self.equations[node.place].normal.map(|entry| self.scale * entry);
        }
        for ((_, slope, sign), bond) in self.sides().into_iter().zip(node.bonds) {
            let (continuity, curvature) = (bond * self.stiffness.continuity, bond * self.stiffness.curvature);
            for first in [0, 3] {
                let along = first + slope;
                matrix[packed(first, first)] += continuity;
                matrix[packed(along, along)] += 0.25 * continuity;
                matrix[packed(first, along)] += 0.5 * sign * continuity;
                for p in [first + 1, first + 2] {
                    matrix[packed(p, p)] += curvature;
                }
            }
        }
        node.factors = factor(matrix);
    }

    fn sides(&self) -> [Side; 4] {
        let row = self.grid.columns.cast_signed();
        [(1, 1, 1.0), (-1, 1, -1.0), (row, 2, 1.0), (-row, 2, -1.0)]
    }

    /// Minimises the energy over one node's step.
    fn relax(&self, nodes: &mut [FineNode], k: usize) {
        let node = &nodes[k];
        let mut here = self.field[node.place];
        for (here, step) in here.iter_mut().zip(node.step) {
            *here += step;
        }
        let mut gradient = [0.0; UNKNOWNS];
        if node.is_trusted {
            gradient = node.gradient(&self.equations[node.place], self.scale);
        }
        for ((offset, slope, sign), bond) in self.sides().into_iter().zip(node.bonds) {
            let place = node.place.wrapping_add_signed(offset);
            let mut there = self.field[place];
            if self.index[place] != NONE {
                for (value, step) in there.iter_mut().zip(nodes[self.index[place] as usize].step) {
                    *value += step;
                }
            }
            let (continuity, curvature) = (bond * self.stiffness.continuity, bond * self.stiffness.curvature);
            for first in [0, 3] {
                let along = first + slope;
                let mismatch = sign * (here[first] - there[first]) + 0.5 * (here[along] + there[along]);
                gradient[first] += sign * continuity * mismatch;
                gradient[along] += 0.5 * continuity * mismatch;
                for p in [first + 1, first + 2] {
                    gradient[p] += curvature * (here[p] - there[p]);
                }
            }
        }
        let change = substitute(&nodes[k].factors, gradient);
        for (step, change) in nodes[k].step.iter_mut().zip(change) {
            *step -= change;
        }
    }

    /// Roughness of a pair before the step, relative to what the prior expects.
    fn roughness(&self, place: usize, (offset, slope, sign): Side) -> f32 {
        let (here, there) = (self.field[place], self.field[place.wrapping_add_signed(offset)]);
        let mut sum = 0.0;
        for first in [0, 3] {
            let along = first + slope;
            let mismatch = sign * (here[first] - there[first]) + 0.5 * (here[along] + there[along]);
            let bending = (here[first + 1] - there[first + 1]).powi(2) + (here[first + 2] - there[first + 2]).powi(2);
            sum += self.stiffness.continuity * mismatch * mismatch + self.stiffness.curvature * bending;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(seed: &mut u32) -> f32 {
        *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*seed >> 8) as f32 / 8_388_608.0 - 1.0
    }

    /// Energy of three nodes' patches and of their couplings, from its definition.
    fn energy(relaxation: &Relaxation<'_>, nodes: &[FineNode]) -> f64 {
        let Relaxation { grid, stiffness, scale, field, index, .. } = *relaxation;
        let mut sum = 0.0;
        for node in nodes.iter().filter(|node| node.is_trusted) {
            for i in 0..UNKNOWNS {
                let normal = &relaxation.equations[node.place].normal;
                let image: f32 = (0..UNKNOWNS).map(|j| normal[packed(i, j)] * node.step[j]).sum();
                sum += f64::from(node.step[i] * (scale * image - 2.0 * node.right[i]));
            }
        }
        let at = |place: usize| -> Motion {
            let step = nodes.get(index[place] as usize).map_or([0.0; UNKNOWNS], |node| node.step);
            std::array::from_fn(|p| field[place][p] + step[p])
        };
        for place in 0..grid.nodes() {
            let pairs =
                [((place + 1) % grid.columns != 0, 1, 1), (place + grid.columns < grid.nodes(), grid.columns, 2)];
            for (_, offset, slope) in pairs.into_iter().filter(|(exists, ..)| *exists) {
                let (near, far) = (at(place), at(place + offset));
                let bond = stiffness.tolerance
                    / (stiffness.tolerance + relaxation.roughness(place, (offset.cast_signed(), slope, 1.0)));
                for first in [0, 3] {
                    let mismatch = near[first] - far[first] + 0.5 * (near[first + slope] + far[first + slope]);
                    let bending: f32 = [1, 2].map(|k| (near[first + k] - far[first + k]).powi(2)).iter().sum();
                    sum +=
                        f64::from(bond * (stiffness.continuity * mismatch * mismatch + stiffness.curvature * bending));
                }
            }
        }
        sum
    }

    #[test]
    fn sweeps_find_the_least_energy() {
        let grid = FineGrid::over(24, 20);
        let mut seed = 5;
        let field: Vec<Motion> = (0..grid.nodes()).map(|_| std::array::from_fn(|_| 0.2 * noise(&mut seed))).collect();
        let mut equations = vec![PatchEquations::default(); grid.nodes()];
        let mut index = vec![NONE; grid.nodes()];
        let mut nodes = Vec::new();
        for (k, place) in [7, 8, 13, 14, 15].into_iter().enumerate() {
            for i in 0..UNKNOWNS {
                for j in 0..i {
                    equations[place].normal[packed(i, j)] = noise(&mut seed);
                }
                equations[place].normal[packed(i, i)] = 8.0 + noise(&mut seed);
            }
            index[place] = k as u32;
            let right = std::array::from_fn(|_| 3.0 * noise(&mut seed));
            nodes.push(FineNode { right, is_trusted: place != 13, ..FineNode::at(place, 0.0) });
        }
        let stiffness = Stiffness { continuity: 3.0, curvature: 2.0, tolerance: 4.0 };
        let relaxation =
            Relaxation { equations: &equations, grid, stiffness, scale: 0.5, field: &field, index: &index };
        relaxation.run(&mut nodes, 60);
        let least = energy(&relaxation, &nodes);
        for k in 0..nodes.len() {
            for p in 0..UNKNOWNS {
                for change in [-0.05, 0.05] {
                    let mut moved = nodes.clone();
                    moved[k].step[p] += change;
                    let found = energy(&relaxation, &moved);
                    assert!(found > least, "node {k}, unknown {p} by {change}: {found} below {least}");
                }
            }
        }
    }
}

//! Couples fine patches with their neighbours and solves for their steps.
//!
//! The energy is that of the coarse patches ([`crate::affine::coupling`]), with half the stride. Nodes that are not
//! refined keep the coarse field. The refined nodes lie in narrow bands along rims, so Gauss–Seidel sweeps converge
//! quickly.

use super::grid::FineGrid;
use super::node::{FineNode, Motion, factor};
use crate::affine::bonds::Stiffness;
use crate::affine::nodes::UNKNOWNS;
use crate::affine::symmetric::{PACKED, packed};
use crate::affine::template::PatchEquations;

/// Index of a node that is not refined.
pub(super) const NONE: u32 = u32::MAX;

/// The six unknowns of a node and two zeros: a register.
type Padded = [f32; LANES];
const LANES: usize = 8;

/// A neighbour: offset of its index, which slope is the one along the pair, and 1 if it comes after the node, −1 if
/// before.
type Side = (isize, usize, f32);

/// A node's part of the coupled system `δ = M⁻¹ (c − Σ N δ')`, with the steps `δ'` of its neighbours.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block {
    /// `M⁻¹`, column by column.
    inverse: [Padded; UNKNOWNS],
    /// `c`.
    constant: Padded,
    /// Indices of the neighbours among the refined nodes, or [`NONE`].
    neighbours: [u32; 4],
    bonds: [f32; 4],
}

/// Memory of the solution.
#[derive(Debug, Clone)]
pub(super) struct Blocks {
    blocks: Vec<Block>,
    steps: Vec<Padded>,
}

impl Blocks {
    /// For up to this number of nodes.
    pub(super) fn with_capacity(nodes: usize) -> Self {
        Self { blocks: Vec::with_capacity(nodes), steps: Vec::with_capacity(nodes) }
    }
}

/// Factors of a neighbour's step in `N` for a bond of 1: of an unknown itself, and of its partner (see [`partner`]).
struct Reaction {
    own: Padded,
    partners: Padded,
}

/// The unknown that a pair couples with one: a displacement with the slope along the pair, 1 for x and 2 for y.
const fn partner(unknown: usize, slope: usize) -> usize {
    match unknown % 3 {
        0 if unknown < UNKNOWNS => unknown + slope,
        along if along == slope && unknown < UNKNOWNS => unknown - slope,
        _ => unknown,
    }
}

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
    ///
    /// Always inlined, so that it is compiled for the instruction set of the caller.
    #[inline(always)]
    pub(super) fn run(&self, nodes: &mut [FineNode], Blocks { blocks, steps }: &mut Blocks, sweeps: usize) {
        blocks.clear();
        // A loop, because the compiler does not use the instruction set in closures.
        for node in nodes.iter_mut() {
            blocks.push(self.prepare(node));
        }
        steps.clear();
        steps.resize(nodes.len(), [0.0; LANES]);
        let reactions = self.sides().map(|side| self.reaction(side));
        for sweep in 0..sweeps {
            for k in 0..nodes.len() {
                let k = if sweep % 2 == 0 { k } else { nodes.len() - 1 - k };
                steps[k] = relax(&blocks[k], &reactions, steps);
            }
        }
        for (node, step) in nodes.iter_mut().zip(steps) {
            node.step.copy_from_slice(&step[..UNKNOWNS]);
        }
    }

    /// Computes the bonds of a node from the field, and inverts its block.
    #[inline(always)]
    fn prepare(&self, node: &mut FineNode) -> Block {
        let tolerance = self.stiffness.tolerance;
        let roughness = self.sides().map(|side| self.roughness(node.place, side));
        node.roughness = 0.25 * roughness.iter().sum::<f32>();
        let bonds = roughness.map(|roughness| tolerance / (tolerance + roughness));
        let (mut matrix, mut constant) = ([0.0; PACKED], [0.0; LANES]);
        if node.is_trusted {
            matrix = self.equations[node.place].normal.map(|entry| self.scale * entry);
            constant[..UNKNOWNS].copy_from_slice(&node.right);
        }
        let here = &self.field[node.place];
        for ((offset, slope, sign), bond) in self.sides().into_iter().zip(bonds) {
            let (continuity, curvature) = (bond * self.stiffness.continuity, bond * self.stiffness.curvature);
            let there = &self.field[node.place.wrapping_add_signed(offset)];
            for first in [0, 3] {
                let along = first + slope;
                matrix[packed(first, first)] += continuity;
                matrix[packed(along, along)] += 0.25 * continuity;
                matrix[packed(first, along)] += 0.5 * sign * continuity;
                let mismatch = sign * (here[first] - there[first]) + 0.5 * (here[along] + there[along]);
                constant[first] -= sign * continuity * mismatch;
                constant[along] -= 0.5 * continuity * mismatch;
                for p in [first + 1, first + 2] {
                    matrix[packed(p, p)] += curvature;
                    constant[p] -= curvature * (here[p] - there[p]);
                }
            }
        }
        let neighbours = self.sides().map(|(offset, ..)| self.index[node.place.wrapping_add_signed(offset)]);
        Block { inverse: inverse(&factor(matrix)), constant, neighbours, bonds }
    }

    fn sides(&self) -> [Side; 4] {
        let row = self.grid.columns.cast_signed();
        [(1, 1, 1.0), (-1, 1, -1.0), (row, 2, 1.0), (-row, 2, -1.0)]
    }

    /// The derivative of a node's gradient by the step of the neighbour on a side.
    fn reaction(&self, (_, slope, sign): Side) -> Reaction {
        let Stiffness { continuity, curvature, .. } = self.stiffness;
        let mut reaction = Reaction { own: [0.0; LANES], partners: [0.0; LANES] };
        for first in [0, 3] {
            let along = first + slope;
            reaction.own[first] = -continuity;
            reaction.own[first + 1] = -curvature;
            reaction.own[first + 2] = -curvature;
            reaction.own[along] += 0.25 * continuity;
            reaction.partners[first] = 0.5 * sign * continuity;
            reaction.partners[along] = -0.5 * sign * continuity;
        }
        reaction
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

/// The step of a node with the least energy, given those of its neighbours.
#[inline(always)]
fn relax(block: &Block, reactions: &[Reaction; 4], steps: &[Padded]) -> Padded {
    let mut right = block.constant;
    subtract::<1>(&mut right, block, 0, &reactions[0], steps);
    subtract::<1>(&mut right, block, 1, &reactions[1], steps);
    subtract::<2>(&mut right, block, 2, &reactions[2], steps);
    subtract::<2>(&mut right, block, 3, &reactions[3], steps);
    let mut step = [0.0; LANES];
    for (column, right) in block.inverse.iter().zip(right) {
        for k in 0..LANES {
            step[k] += column[k] * right;
        }
    }
    step
}

/// Subtracts `N δ'` of the neighbour on a side, along which the slope is unknown number `SLOPE`.
#[inline(always)]
fn subtract<const SLOPE: usize>(right: &mut Padded, block: &Block, side: usize, reaction: &Reaction, steps: &[Padded]) {
    // A node that is not refined takes no step.
    let Some(step) = steps.get(block.neighbours[side] as usize) else { return };
    for k in 0..LANES {
        let change = reaction.own[k] * step[k] + reaction.partners[k] * step[partner(k, SLOPE)];
        right[k] -= block.bonds[side] * change;
    }
}

/// The inverse of a matrix, column by column, from its factors: see [`factor`].
#[inline(always)]
fn inverse(factors: &[f32; PACKED]) -> [Padded; UNKNOWNS] {
    let mut columns: [Padded; UNKNOWNS] = std::array::from_fn(|i| std::array::from_fn(|k| f32::from(u8::from(i == k))));
    for i in 1..UNKNOWNS {
        for j in 0..i {
            for k in 0..LANES {
                columns[i][k] -= factors[packed(i, j)] * columns[j][k];
            }
        }
    }
    for (i, column) in columns.iter_mut().enumerate() {
        for value in column {
            *value *= factors[packed(i, i)];
        }
    }
    for i in (0..UNKNOWNS).rev() {
        for j in i + 1..UNKNOWNS {
            for k in 0..LANES {
                columns[i][k] -= factors[packed(j, i)] * columns[j][k];
            }
        }
    }
    columns
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
        relaxation.run(&mut nodes, &mut Blocks::with_capacity(8), 60);
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

//! Couples neighbouring patches: the prior that the flow is smooth.
//!
//! The increments `δ` of all nodes minimise
//!
//! ```text
//! Σ_i m_i (δᵢᵀ Aᵢ δᵢ − 2 bᵢᵀ δᵢ)  +  Σ_ij |c_ij|²/s_c²  +  Σ_ij |∇_i − ∇_j|²/s_k²
//! ```
//!
//! with the patches' normal equations `A, b` in units of the image noise, `m` 1 where a patch is valid, less where its
//! gradient is partly noise, and 0 where it failed. For neighbours `i, j` the mismatch `c_ij` is the difference of their
//! affine predictions half-way, which vanishes on any quadratic field, and `∇` are their gradients in px per stride.
//! Where texture is rich the image determines the flow, where it is poor the neighbours do. The system is solved by a fixed number of
//! conjugate-gradient steps. Their preconditioner consists of the nodes' own 6×6 blocks, with the current bonds, and
//! those of two coarser grids ([`super::coarse_grids`]). This is the regularised digital image correlation of
//! [Hild2012] on patches instead of elements.

use super::bonds::{Bonds, Stiffness};
use super::coarse_grids::{CoarseBlocks, CoarseGrids};
use super::grid::{LANES, PatchGrid};
use super::nodes::{NodeField, Planes, UNKNOWNS};
use super::symmetric::{PACKED, packed};
use crate::multiply_add::multiply_add;
use fearless_simd::{Simd, f32x16, prelude::*};
use fearless_simd_macros::simd;

/// Least pivot of a node's block, also added to its diagonal, per px².
const LEAST_PIVOT: f32 = 1e-3;

/// The solver and its scratch memory.
#[derive(Debug, Clone)]
pub(crate) struct Coupling {
    bonds: Bonds,
    /// Sums of every node's bonds along rows and along columns.
    bond_sums: [Vec<f32>; 2],
    /// Factors of every node's own block, packed: those of [`LANES`] nodes together.
    factors: Vec<[[f32; LANES]; PACKED]>,
    coarse: CoarseGrids,
    residual: Planes,
    preconditioned: Planes,
    direction: Planes,
    image: Planes,
}

impl Coupling {
    pub(crate) fn new(grid: PatchGrid, stiffness: Stiffness) -> Self {
        let plane = || vec![0.0; grid.plane_len()];
        let planes = || std::array::from_fn(|_| plane());
        Self {
            bonds: Bonds::new(grid, stiffness),
            bond_sums: [plane(), plane()],
            factors: vec![[[0.0; LANES]; PACKED]; grid.plane_len() / LANES],
            coarse: CoarseGrids::new(grid),
            residual: planes(),
            preconditioned: planes(),
            direction: planes(),
            image: planes(),
        }
    }

    /// The stiffness of the coupling.
    pub(crate) fn stiffness(&self) -> Stiffness {
        self.bonds.stiffness()
    }

    /// Mean roughness of the field at a node: see [`Bonds::roughness`].
    pub(crate) fn roughness(&self, node: usize) -> f32 {
        self.bonds.roughness(node)
    }

    /// Sets the inverse blocks of the coarser grids.
    pub(crate) fn set_coarse_blocks(&self, normal: &[Vec<f32>; PACKED], scale: f32, blocks: &mut CoarseBlocks) {
        self.coarse.set_blocks(normal, scale, self.bonds.stiffness(), blocks);
    }

    /// Factors every node's own block, patch and bonds, into `L D Lᵀ`: `L` below the diagonal, `1/D` on it.
    #[simd]
    fn factor<S: Simd>(&mut self, simd: S, system: &System<'_>) {
        let [beside, above] = &mut self.bond_sums;
        self.bonds.sum_into(beside, above);
        let Stiffness { continuity, curvature, .. } = self.bonds.stiffness();
        let count = self.factors.len();
        let (normal, [trust, beside, above]) =
            (blocks(system.normal, count), [system.trust, beside, above].map(|plane| in_blocks(plane, count)));
        for (index, factors) in self.factors.iter_mut().enumerate() {
            let load = |plane: &[[f32; LANES]]| f32x16::load_array_ref(simd, &plane[index]);
            let weight = load(trust) * system.scale;
            let mut block: [_; PACKED] = std::array::from_fn(|k| load(normal[k]) * weight);
            let (beside, above) = (load(beside), load(above));
            // A single patch has no neighbour: the small diagonal keeps its block invertible.
            let all = (beside + above) * continuity + LEAST_PIVOT;
            let slopes = (beside + above) * curvature + LEAST_PIVOT;
            let along = [all, beside.mul_add(0.25 * continuity, slopes), above.mul_add(0.25 * continuity, slopes)];
            for i in 0..UNKNOWNS {
                block[packed(i, i)] = block[packed(i, i)] + along[i % 3];
            }
            for i in 0..UNKNOWNS {
                for j in 0..i {
                    // Not yet divided by D: done at the end of the row.
                    for k in 0..j {
                        block[packed(i, j)] = block[packed(i, k)].mul_add(-block[packed(j, k)], block[packed(i, j)]);
                    }
                }
                for j in 0..i {
                    let scaled = block[packed(i, j)] * block[packed(j, j)];
                    block[packed(i, i)] = block[packed(i, j)].mul_add(-scaled, block[packed(i, i)]);
                    block[packed(i, j)] = scaled;
                }
                block[packed(i, i)] = 1.0 / block[packed(i, i)].max(LEAST_PIVOT);
            }
            for (factors, block) in factors.iter_mut().zip(block) {
                block.store_array(factors);
            }
        }
    }

    /// Writes the increments into `increment`: `iterations` steps from zero.
    ///
    /// `field` is the current flow, whose own roughness is part of the prior.
    #[simd]
    pub(crate) fn solve<S: Simd>(
        &mut self,
        simd: S,
        system: &System<'_>,
        field: &NodeField,
        increment: &mut NodeField,
        iterations: usize,
    ) {
        self.bonds.update(simd, &field.planes);
        self.factor(simd, system);
        clear(&mut self.image);
        self.bonds.add_product(simd, &field.planes, &mut self.image);
        for (residual, (right, image)) in self.residual.iter_mut().zip(system.right.iter().zip(&self.image)) {
            let terms = right.iter().zip(image).zip(system.trust);
            for (residual, ((right, image), trust)) in residual.iter_mut().zip(terms) {
                *residual = trust * right - image;
            }
        }
        clear(&mut increment.planes);
        clear(&mut self.direction);
        let mut previous = f32::INFINITY;
        for _ in 0..iterations {
            substitute(simd, &self.factors, &self.residual, &mut self.preconditioned);
            self.coarse.correct(simd, system.coarse, &self.residual, &mut self.preconditioned);
            let product = dot(simd, &self.residual, &self.preconditioned);
            let momentum = product / previous;
            previous = product;
            advance(simd, &mut self.direction, &self.preconditioned, momentum);
            system.apply(simd, &self.direction, &mut self.image);
            self.bonds.add_product(simd, &self.direction, &mut self.image);
            let curvature = dot(simd, &self.direction, &self.image);
            if curvature <= f32::MIN_POSITIVE || product <= f32::MIN_POSITIVE {
                return; // converged to rounding
            }
            let step = product / curvature;
            accumulate(simd, &mut increment.planes, &self.direction, step);
            accumulate(simd, &mut self.residual, &self.image, -step);
        }
    }
}

/// The patches' part of the system.
pub(crate) struct System<'a> {
    pub(crate) normal: &'a [Vec<f32>; PACKED],
    /// Inverse blocks of the nodes of coarser grids.
    pub(crate) coarse: &'a CoarseBlocks,
    /// Factor on `normal`: one over the noise variance, and over the patches' overlap.
    pub(crate) scale: f32,
    /// `m`: the part of the patch's gradient that is not noise, 0 where the patch failed.
    pub(crate) trust: &'a [f32],
    /// `b`, scaled like `normal`.
    pub(crate) right: &'a Planes,
}

impl System<'_> {
    /// `y = m N x` with the packed symmetric 6×6 matrix `N` of every node's patch.
    #[simd]
    fn apply<S: Simd>(&self, simd: S, x: &Planes, y: &mut Planes) {
        let count = self.trust.len() / LANES;
        let (normal, x, trust) = (blocks(self.normal, count), blocks(x, count), in_blocks(self.trust, count));
        let y = blocks_mut(y, count);
        for index in 0..count {
            let load = |plane: &[[f32; LANES]]| f32x16::load_array_ref(simd, &plane[index]);
            let x: [_; UNKNOWNS] = std::array::from_fn(|i| load(x[i]));
            let weight = load(trust) * self.scale;
            for i in 0..UNKNOWNS {
                let mut sum = load(normal[packed(i, 0)]) * x[0];
                for j in 1..UNKNOWNS {
                    sum = load(normal[packed(i, j)]).mul_add(x[j], sum);
                }
                (sum * weight).store_array(&mut y[i][index]);
            }
        }
    }
}

/// `y = (L D Lᵀ)⁻¹ x` at every node.
#[simd]
fn substitute<S: Simd>(simd: S, factors: &[[[f32; LANES]; PACKED]], x: &Planes, y: &mut Planes) {
    let (x, y) = (blocks(x, factors.len()), blocks_mut(y, factors.len()));
    for (index, factors) in factors.iter().enumerate() {
        let factor = |i: usize, j: usize| f32x16::load_array_ref(simd, &factors[packed(i, j)]);
        let mut y_here: [_; UNKNOWNS] = std::array::from_fn(|i| f32x16::load_array_ref(simd, &x[i][index]));
        for i in 1..UNKNOWNS {
            for j in 0..i {
                y_here[i] = factor(i, j).mul_add(-y_here[j], y_here[i]);
            }
        }
        for i in 0..UNKNOWNS {
            y_here[i] *= factor(i, i);
        }
        for i in (0..UNKNOWNS).rev() {
            for j in i + 1..UNKNOWNS {
                y_here[i] = factor(j, i).mul_add(-y_here[j], y_here[i]);
            }
        }
        for i in 0..UNKNOWNS {
            y_here[i].store_array(&mut y[i][index]);
        }
    }
}

/// Planes in blocks of [`LANES`] nodes, all of one length, so that the kernels check no bounds.
#[inline(always)]
fn blocks<const N: usize>(planes: &[Vec<f32>; N], count: usize) -> [&[[f32; LANES]]; N] {
    planes.each_ref().map(|plane| in_blocks(plane, count))
}

/// As [`blocks`], of one plane.
#[inline(always)]
fn in_blocks(plane: &[f32], count: usize) -> &[[f32; LANES]] {
    &plane.as_chunks().0[..count]
}

/// As [`blocks`].
#[inline(always)]
fn blocks_mut<const N: usize>(planes: &mut [Vec<f32>; N], count: usize) -> [&mut [[f32; LANES]]; N] {
    planes.each_mut().map(|plane| &mut plane.as_chunks_mut().0[..count])
}

fn clear(planes: &mut Planes) {
    for plane in planes {
        plane.fill(0.0);
    }
}

/// `x ← y + factor · x`.
#[simd]
fn advance<S: Simd>(simd: S, x: &mut Planes, y: &Planes, factor: f32) {
    for (x, y) in x.iter_mut().zip(y) {
        for (x, y) in x.iter_mut().zip(y) {
            *x = multiply_add(simd, factor, *x, *y);
        }
    }
}

/// `x ← x + factor · y`.
#[simd]
fn accumulate<S: Simd>(simd: S, x: &mut Planes, y: &Planes, factor: f32) {
    for (x, y) in x.iter_mut().zip(y) {
        for (x, y) in x.iter_mut().zip(y) {
            *x = multiply_add(simd, factor, *y, *x);
        }
    }
}

#[simd]
fn dot<S: Simd>(simd: S, x: &Planes, y: &Planes) -> f32 {
    let mut sum = f32x16::splat(simd, 0.0);
    for (x, y) in x.iter().zip(y) {
        for (x, y) in x.chunks_exact(LANES).zip(y.chunks_exact(LANES)) {
            sum = f32x16::from_slice(simd, x).mul_add(f32x16::from_slice(simd, y), sum);
        }
    }
    sum.reduce_sum()
}

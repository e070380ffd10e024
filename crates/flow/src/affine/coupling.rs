//! Neighbouring patches pull on each other: the prior that the flow is smooth.
//!
//! The increments `δ` of all nodes minimise
//!
//! ```text
//! Σ_i m_i (δᵢᵀ Aᵢ δᵢ − 2 bᵢᵀ δᵢ)  +  Σ_ij |c_ij|²/s_c²  +  Σ_ij |∇_i − ∇_j|²/s_k²
//! ```
//!
//! with the patches' normal equations `A, b` in units of the image noise, `m` 1 where a patch is trusted and 0 where
//! it failed. For neighbours `i, j` the mismatch `c_ij` is the difference of their affine predictions half-way, which
//! vanishes on any quadratic field, and `∇` are their gradients in px per stride. Where texture is rich the data
//! decide; where it is poor the neighbours do. The system is solved by a fixed number of conjugate-gradient steps with
//! the nodes' own 6×6 blocks as preconditioner. This is the regularised digital image correlation of [Hild2012] on
//! patches instead of elements.

use super::bonds::{Bonds, Stiffness};
use super::grid::{LANES, PatchGrid};
use super::nodes::{NodeField, Planes, UNKNOWNS};
use super::template::{PACKED, packed};
use fearless_simd::{Level, Simd, dispatch, f32x16, prelude::*};
use fearless_simd_macros::simd;

/// The solver and its scratch.
#[derive(Debug, Clone)]
pub(crate) struct Coupling {
    grid: PatchGrid,
    bonds: Bonds,
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
            grid,
            bonds: Bonds::new(grid, stiffness),
            residual: planes(),
            preconditioned: planes(),
            direction: planes(),
            image: planes(),
        }
    }

    /// The stiffness of the pull.
    pub(crate) fn stiffness(&self) -> Stiffness {
        self.bonds.stiffness()
    }

    /// Weighs the bonds for a field that is not to be moved.
    pub(crate) fn weigh(&mut self, level: Level, field: &NodeField) {
        dispatch!(level, simd => self.bonds.weigh(simd, &field.planes));
    }

    /// Mean roughness of the field at a node; see [`Bonds::roughness`].
    pub(crate) fn roughness(&self, node: usize) -> f32 {
        self.bonds.roughness(node)
    }

    /// Writes the packed inverse of every node's own block: patch and stiffness.
    pub(crate) fn precondition(&self, normal: &[Vec<f32>; PACKED], scale: f32, inverses: &mut [Vec<f32>; PACKED]) {
        for node in 0..self.grid.nodes() {
            let mut block = [[0.0; UNKNOWNS]; UNKNOWNS];
            for (i, row) in block.iter_mut().enumerate() {
                for (j, entry) in row.iter_mut().enumerate() {
                    *entry = f64::from(scale * normal[packed(i, j)][node]);
                }
            }
            let diagonal = self.own_stiffness(node);
            for (i, row) in block.iter_mut().enumerate() {
                row[i] += diagonal[i % 3];
            }
            let inverse = invert(block);
            for i in 0..UNKNOWNS {
                for j in 0..=i {
                    inverses[packed(i, j)][node] = inverse[i][j] as f32;
                }
            }
        }
    }

    /// Diagonal of the coupling at a node for value, x slope and y slope.
    fn own_stiffness(&self, node: usize) -> [f64; 3] {
        let (i, j) = (node % self.grid.columns, node / self.grid.columns);
        let beside = f64::from(u8::from(i > 0) + u8::from(i + 1 < self.grid.columns));
        let above = f64::from(u8::from(j > 0) + u8::from(j + 1 < self.grid.rows));
        let stiffness = self.bonds.stiffness();
        let (continuity, curvature) = (f64::from(stiffness.continuity), f64::from(stiffness.curvature));
        // A lone patch has no neighbour; a trace keeps its block invertible.
        let slopes = curvature * (beside + above) + 1e-6;
        [continuity * (beside + above) + 1e-6, slopes + 0.25 * continuity * beside, slopes + 0.25 * continuity * above]
    }

    /// Writes the increments into `increment`: `iterations` steps from zero.
    ///
    /// `field` is the present flow, whose own roughness the prior also counts.
    #[simd]
    pub(crate) fn solve<S: Simd>(
        &mut self,
        simd: S,
        system: &System<'_>,
        field: &NodeField,
        increment: &mut NodeField,
        iterations: usize,
    ) {
        self.bonds.weigh(simd, &field.planes);
        clear(&mut self.image);
        self.bonds.pull(simd, &field.planes, &mut self.image);
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
            multiply(simd, system.preconditioner, &self.residual, &mut self.preconditioned);
            let product = dot(simd, &self.residual, &self.preconditioned);
            let momentum = product / previous;
            previous = product;
            advance(simd, &mut self.direction, &self.preconditioned, momentum);
            system.apply(simd, &self.direction, &mut self.image);
            self.bonds.pull(simd, &self.direction, &mut self.image);
            let curvature = dot(simd, &self.direction, &self.image);
            if curvature <= f32::MIN_POSITIVE || product <= f32::MIN_POSITIVE {
                return; // converged to the last bit: nothing left to correct
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
    /// Inverse of every node's own block.
    pub(crate) preconditioner: &'a [Vec<f32>; PACKED],
    /// Factor on `normal`: one over the noise variance, and over the patches' overlap.
    pub(crate) scale: f32,
    /// `m`: 1 where the patch is trusted, else 0.
    pub(crate) trust: &'a [f32],
    /// `b`, scaled like `normal`.
    pub(crate) right: &'a Planes,
}

impl System<'_> {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, x: &Planes, y: &mut Planes) {
        multiply(simd, self.normal, x, y);
        for y in y {
            for (y, trust) in y.iter_mut().zip(self.trust) {
                *y *= self.scale * trust;
            }
        }
    }
}

/// `y = M x` with a packed symmetric 6×6 matrix at every node.
#[simd]
fn multiply<S: Simd>(simd: S, matrix: &[Vec<f32>; PACKED], x: &Planes, y: &mut Planes) {
    for start in (0..x[0].len()).step_by(LANES) {
        let load = |plane: &Vec<f32>| f32x16::from_slice(simd, &plane[start..][..LANES]);
        let x: [_; UNKNOWNS] = std::array::from_fn(|i| load(&x[i]));
        for (i, y) in y.iter_mut().enumerate() {
            let mut sum = load(&matrix[packed(i, 0)]) * x[0];
            for (j, &x) in x.iter().enumerate().skip(1) {
                sum = load(&matrix[packed(i, j)]).mul_add(x, sum);
            }
            sum.store_slice(&mut y[start..][..LANES]);
        }
    }
}

fn clear(planes: &mut Planes) {
    for plane in planes {
        plane.fill(0.0);
    }
}

/// `x ← y + factor · x`.
#[simd]
fn advance<S: Simd>(simd: S, x: &mut Planes, y: &Planes, factor: f32) {
    let _ = simd;
    for (x, y) in x.iter_mut().zip(y) {
        for (x, y) in x.iter_mut().zip(y) {
            *x = y + factor * *x;
        }
    }
}

/// `x ← x + factor · y`.
#[simd]
fn accumulate<S: Simd>(simd: S, x: &mut Planes, y: &Planes, factor: f32) {
    let _ = simd;
    for (x, y) in x.iter_mut().zip(y) {
        for (x, y) in x.iter_mut().zip(y) {
            *x += factor * y;
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

/// Inverse of a symmetric positive definite matrix, by Gauss–Jordan without pivoting.
pub(crate) fn invert(mut matrix: [[f64; UNKNOWNS]; UNKNOWNS]) -> [[f64; UNKNOWNS]; UNKNOWNS] {
    let mut inverse: [[f64; UNKNOWNS]; UNKNOWNS] =
        std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    for pivot in 0..UNKNOWNS {
        let scale = 1.0 / matrix[pivot][pivot];
        for k in 0..UNKNOWNS {
            matrix[pivot][k] *= scale;
            inverse[pivot][k] *= scale;
        }
        for row in (0..UNKNOWNS).filter(|&row| row != pivot) {
            let factor = matrix[row][pivot];
            for k in 0..UNKNOWNS {
                matrix[row][k] -= factor * matrix[pivot][k];
                inverse[row][k] -= factor * inverse[pivot][k];
            }
        }
    }
    inverse
}

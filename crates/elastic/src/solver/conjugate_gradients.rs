//! Preconditioned conjugate gradients ([Saad2003]), in a subspace that constraints leave.

use super::{Field, Grid, Multigrid, Stencil};
use rayon::prelude::*;

/// How a solve ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Outcome {
    /// Steps taken.
    pub(crate) iterations: usize,
    /// Norm of the residual over that of the right side, dimensionless.
    pub(crate) relative_residual: f64,
    /// Whether a direction was met along which the matrix is not positive; the solution is what came before it.
    pub(crate) is_indefinite: bool,
}

/// Solves with scratch of its own.
#[derive(Debug)]
pub(crate) struct Solver {
    grid: Grid,
    residual: Vec<[f64; 3]>,
    direction: Vec<[f64; 3]>,
    product: Vec<[f64; 3]>,
    preconditioned: Vec<[f64; 3]>,
    single: Vec<[f32; 3]>,
}

impl Solver {
    pub(crate) fn new(grid: Grid) -> Self {
        let field = || vec![[0.0; 3]; grid.len()];
        let (residual, direction, product, preconditioned) = (field(), field(), field(), field());
        Self { grid, residual, direction, product, preconditioned, single: vec![[0.0; 3]; grid.len()] }
    }

    /// Solves `P A P x = P b` for `x = P x`, where `project` applies the projector `P` to a field.
    ///
    /// Ends when the residual is `tolerance` times the right side, after `limit` steps, or where `A` is not positive.
    pub(crate) fn solve(
        &mut self,
        matrix: &Stencil<f64>,
        multigrid: &mut Multigrid,
        (right, solution): (&Field<f64>, &mut Field<f64>),
        project: &(dyn Fn(&mut Field<f64>) + Sync),
        (tolerance, limit): (f64, usize),
    ) -> Outcome {
        let grid = self.grid;
        solution.fill([0.0; 3]);
        self.residual.copy_from_slice(right);
        project(&mut self.residual);
        let start = dot(grid, &self.residual, &self.residual).sqrt();
        let mut outcome = Outcome { iterations: 0, relative_residual: 0.0, is_indefinite: false };
        if start <= 0.0 {
            return outcome;
        }
        outcome.relative_residual = 1.0;
        self.precondition(multigrid, project);
        self.direction.copy_from_slice(&self.preconditioned);
        let mut slope = dot(grid, &self.residual, &self.preconditioned);
        while outcome.iterations < limit && outcome.relative_residual > tolerance {
            matrix.multiply_into(&self.direction, &mut self.product);
            project(&mut self.product);
            let curvature = dot(grid, &self.direction, &self.product);
            if curvature <= 0.0 {
                outcome.is_indefinite = true;
                return outcome;
            }
            let step = slope / curvature;
            add_scaled(solution, step, &self.direction);
            add_scaled(&mut self.residual, -step, &self.product);
            outcome.iterations += 1;
            outcome.relative_residual = dot(grid, &self.residual, &self.residual).sqrt() / start;
            self.precondition(multigrid, project);
            let next_slope = dot(grid, &self.residual, &self.preconditioned);
            // Polak and Ribière's form forgives a preconditioner that rounds: ⟨z₊, r₊ − r⟩ / ⟨z, r⟩, r₊ − r = −step · A p.
            let turn = (-step * dot(grid, &self.product, &self.preconditioned) / slope).max(0.0);
            self.direction.par_iter_mut().zip(self.preconditioned.par_iter()).for_each(|(direction, towards)| {
                *direction = [0, 1, 2].map(|c| towards[c] + turn * direction[c]);
            });
            slope = next_slope;
        }
        outcome
    }

    fn precondition(&mut self, multigrid: &mut Multigrid, project: &(dyn Fn(&mut Field<f64>) + Sync)) {
        // Single precision holds few tiny numbers: the cycle sees a residual of size one.
        let scale = dot(self.grid, &self.residual, &self.residual).sqrt().max(f64::MIN_POSITIVE);
        self.single.par_iter_mut().zip(self.residual.par_iter()).for_each(|(single, value)| {
            *single = value.map(|value| (value / scale) as f32);
        });
        let correction = multigrid.apply(&self.single);
        self.preconditioned.par_iter_mut().zip(correction.par_iter()).for_each(|(double, value)| {
            *double = value.map(|value| scale * f64::from(value));
        });
        project(&mut self.preconditioned);
    }
}

/// Scalar product of two fields, summed slab by slab.
pub(crate) fn dot(grid: Grid, a: &Field<f64>, b: &Field<f64>) -> f64 {
    let slab = grid.slab();
    let sums: Vec<f64> = a
        .par_chunks(slab)
        .zip(b.par_chunks(slab))
        .map(|(a, b)| a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| a * b).sum())
        .collect();
    sums.iter().sum()
}

fn add_scaled(target: &mut Field<f64>, factor: f64, source: &Field<f64>) {
    target.par_iter_mut().zip(source.par_iter()).for_each(|(target, source)| {
        *target = [0, 1, 2].map(|c| target[c] + factor * source[c]);
    });
}

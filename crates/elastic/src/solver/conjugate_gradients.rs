//! Preconditioned conjugate gradients ([Saad2003]), in the subspace allowed by constraints.
//!
//! Matrix and vectors are in single precision: the Newton iteration, with its residual in double precision, corrects the
//! rest. Scalar products are summed in double.

use super::grid::LEAST_VALUES;
use super::{Field, Grid, Multigrid};
use rayon::prelude::*;

/// The outcome of a solve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Outcome {
    /// Steps taken.
    pub(crate) iterations: usize,
    /// Norm of the residual over that of the right side, dimensionless.
    pub(crate) relative_residual: f64,
    /// Whether a direction was found along which the matrix is not positive; the solution is the one before it.
    pub(crate) is_indefinite: bool,
}

/// The solver with its scratch memory.
#[derive(Debug)]
pub(crate) struct Solver {
    grid: Grid,
    residual: Vec<[f32; 3]>,
    direction: Vec<[f32; 3]>,
    product: Vec<[f32; 3]>,
    preconditioned: Vec<[f32; 3]>,
    solution: Vec<[f32; 3]>,
}

impl Solver {
    pub(crate) fn new(grid: Grid) -> Self {
        let field = || vec![[0.0; 3]; grid.len()];
        let (residual, direction, product, preconditioned) = (field(), field(), field(), field());
        Self { grid, residual, direction, product, preconditioned, solution: field() }
    }

    /// Solves `P A P x = P b` for `x = P x`, where `A` is the hierarchy's finest matrix and `project` applies the
    /// projector `P` to a field. `P` and `A` need to commute, as they do once the matrix is constrained.
    ///
    /// Ends when the residual has the norm `goal` or `tolerance` times that of the right side, whichever is larger,
    /// after `limit` steps, or where `A` is not positive.
    pub(crate) fn solve(
        &mut self,
        multigrid: &mut Multigrid,
        (right, solution): (&Field<f64>, &mut Field<f64>),
        project: &dyn Fn(&mut Field<f32>),
        Stop { goal, tolerance, limit }: Stop,
    ) -> Outcome {
        let grid = self.grid;
        solution.fill([0.0; 3]);
        self.solution.fill([0.0; 3]);
        let mut outcome = Outcome { iterations: 0, relative_residual: 0.0, is_indefinite: false };
        // Single precision represents few tiny numbers: the right side is scaled to size one.
        let scale = dot(grid, right, right).sqrt();
        if scale <= 0.0 {
            return outcome;
        }
        each(&mut self.residual, right, |residual, right| *residual = right.map(|value| (value / scale) as f32));
        project(&mut self.residual);
        let start = dot(grid, &self.residual, &self.residual).sqrt();
        if start <= 0.0 {
            return outcome;
        }
        let tolerance = tolerance.max(goal / (scale * start));
        outcome.relative_residual = 1.0;
        self.precondition(multigrid, project);
        self.direction.copy_from_slice(&self.preconditioned);
        let mut slope = dot(grid, &self.residual, &self.preconditioned);
        while outcome.iterations < limit && outcome.relative_residual > tolerance {
            multigrid.finest().multiply_into(&self.direction, &mut self.product);
            let curvature = dot(grid, &self.direction, &self.product);
            if curvature <= 0.0 {
                outcome.is_indefinite = true;
                break;
            }
            let step = slope / curvature;
            add_scaled(&mut self.solution, step as f32, &self.direction);
            add_scaled(&mut self.residual, -step as f32, &self.product);
            outcome.iterations += 1;
            outcome.relative_residual = dot(grid, &self.residual, &self.residual).sqrt() / start;
            if outcome.relative_residual <= tolerance {
                break;
            }
            self.precondition(multigrid, project);
            let next_slope = dot(grid, &self.residual, &self.preconditioned);
            // Polak and Ribière's form tolerates rounding in the preconditioner: ⟨z₊, r₊ − r⟩ / ⟨z, r⟩, r₊ − r = −step ·
            // A p.
            let turn = (-step * dot(grid, &self.product, &self.preconditioned) / slope).max(0.0) as f32;
            each(&mut self.direction, &self.preconditioned, |direction, towards| {
                *direction = [0, 1, 2].map(|c| towards[c] + turn * direction[c]);
            });
            slope = next_slope;
        }
        project(&mut self.solution);
        each(solution, &self.solution, |target, value| *target = value.map(|value| scale * f64::from(value)));
        outcome
    }

    fn precondition(&mut self, multigrid: &mut Multigrid, project: &dyn Fn(&mut Field<f32>)) {
        self.preconditioned.copy_from_slice(multigrid.apply(&self.residual));
        project(&mut self.preconditioned);
    }
}

/// Termination of a solve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stop {
    /// Norm of the residual that is good enough.
    pub(crate) goal: f64,
    /// The same over the norm of the right side, dimensionless.
    pub(crate) tolerance: f64,
    /// Most steps.
    pub(crate) limit: usize,
}

/// Scalar product of two fields, summed slab by slab.
pub(crate) fn dot<T: Copy + Into<f64> + Sync>(grid: Grid, a: &Field<T>, b: &Field<T>) -> f64 {
    let slab = grid.slab();
    let slabs = a.par_chunks(slab).zip(b.par_chunks(slab)).with_min_len(LEAST_VALUES.div_ceil(slab));
    let of_slab = |(a, b): (&Field<T>, &Field<T>)| -> f64 {
        let mut sums = [0.0; 3];
        for (a, b) in a.iter().zip(b) {
            sums = [0, 1, 2].map(|c| sums[c] + a[c].into() * b[c].into());
        }
        sums[0] + sums[1] + sums[2]
    };
    let sums: Vec<f64> = slabs.map(of_slab).collect();
    sums.iter().sum()
}

fn add_scaled(target: &mut Field<f32>, factor: f32, source: &Field<f32>) {
    each(target, source, |target, source| *target = [0, 1, 2].map(|c| target[c] + factor * source[c]));
}

/// Applies the same operation to every node.
fn each<T: Send, S: Sync>(target: &mut [T], source: &[S], visit: impl Fn(&mut T, &S) + Sync) {
    let nodes = target.par_iter_mut().zip(source.par_iter()).with_min_len(LEAST_VALUES);
    nodes.for_each(|(target, source)| visit(target, source));
}

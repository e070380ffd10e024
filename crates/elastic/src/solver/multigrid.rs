//! One V-cycle of geometric multigrid, as a preconditioner.

use super::coarsen::Coarsening;
use super::grid::LEAST_VALUES;
use super::smoother::{Smoother, Sweep};
use super::{Grid, Stencil};
use rayon::prelude::*;

/// An axis is coarsened while its finest cells are at most this much longer than the finest of all axes.
const SLENDERNESS: f64 = 1.5;
/// An axis with fewer nodes is not coarsened further.
const FEWEST_NODES: usize = 4;
/// Sweeps on the coarsest grid, which has a few dozen nodes.
const COARSEST_SWEEPS: usize = 12;

/// A hierarchy of grids over one mesh.
#[derive(Debug)]
pub(crate) struct Multigrid {
    levels: Vec<Level>,
}

/// A grid with its matrix, and its coarsening.
#[derive(Debug)]
struct Level {
    matrix: Stencil,
    smoother: Smoother,
    solution: Vec<[f32; 3]>,
    right: Vec<[f32; 3]>,
    product: Vec<[f32; 3]>,
    /// Up to three steps, one axis each, to the next level.
    steps: Vec<Step>,
}

/// The coarsening along one axis, and memory for intermediate results.
#[derive(Debug)]
struct Step {
    coarsening: Coarsening,
    /// Absent where the result is a level's own.
    matrix: Option<Stencil>,
    field: Vec<[f32; 3]>,
}

impl Level {
    fn new(grid: Grid) -> Self {
        let field = || vec![[0.0; 3]; grid.len()];
        Self {
            matrix: Stencil::zero(grid),
            smoother: Smoother::new(grid),
            solution: field(),
            right: field(),
            product: field(),
            steps: Vec::new(),
        }
    }
}

impl Multigrid {
    /// A hierarchy for nodes at `lines` along x, y and z, mm, bonded at `base_mm` beyond the last line along z.
    pub(crate) fn new(lines: [&[f64]; 3], base_mm: f64) -> Self {
        let mut lines = lines.map(<[f64]>::to_vec);
        let mut levels = Vec::new();
        loop {
            let mut level = Level::new(Grid { nodes: [0, 1, 2].map(|axis| lines[axis].len()) });
            level.steps = steps(level.matrix.grid, &mut lines, base_mm);
            let is_coarsest = level.steps.is_empty();
            levels.push(level);
            if is_coarsest {
                return Self { levels };
            }
        }
    }

    /// The finest matrix.
    pub(crate) fn finest(&self) -> &Stencil {
        &self.levels[0].matrix
    }

    /// The finest matrix, to be filled before [`Multigrid::refresh`].
    pub(crate) fn finest_mut(&mut self) -> &mut Stencil {
        &mut self.levels[0].matrix
    }

    /// Derives all coarser matrices from the finest.
    pub(crate) fn refresh(&mut self) {
        for index in 0..self.levels.len() {
            let (fine, coarse) = self.levels.split_at_mut(index + 1);
            let level = &mut fine[index];
            level.smoother.refresh(&level.matrix);
            let Some(next) = coarse.first_mut() else { return };
            for step in 0..level.steps.len() {
                let (before, rest) = level.steps.split_at_mut(step);
                let source = before.last().and_then(|step| step.matrix.as_ref()).unwrap_or(&level.matrix);
                let Step { coarsening, matrix, .. } = &mut rest[0];
                coarsening.galerkin_into(source, matrix.as_mut().unwrap_or(&mut next.matrix));
            }
        }
    }

    /// `solution ≈ A⁻¹ right`: a linear, symmetric operator.
    pub(crate) fn apply(&mut self, right: &[[f32; 3]]) -> &[[f32; 3]] {
        self.levels[0].right.copy_from_slice(right);
        cycle(&mut self.levels);
        &self.levels[0].solution
    }
}

/// Which axes to coarsen next, and their coarser lines.
fn steps(fine: Grid, lines: &mut [Vec<f64>; 3], base_mm: f64) -> Vec<Step> {
    let finest = |lines: &[f64]| lines.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let spacings = [0, 1, 2].map(|axis| finest(&lines[axis]));
    let eligible = |axis: usize| lines[axis].len() > FEWEST_NODES;
    let shortest = (0..3).filter(|&axis| eligible(axis)).map(|axis| spacings[axis]).fold(f64::INFINITY, f64::min);
    let chosen: Vec<usize> =
        (0..3).filter(|&axis| eligible(axis) && spacings[axis] <= SLENDERNESS * shortest).collect();
    let mut grid = fine;
    let mut steps: Vec<Step> = Vec::new();
    for &axis in &chosen {
        let bonded = (axis == 2).then_some(base_mm);
        let (coarsening, kept) = Coarsening::new(grid, axis, &lines[axis], bonded);
        grid = coarsening.coarse;
        lines[axis] = kept;
        let matrix = (Some(&axis) != chosen.last()).then(|| Stencil::zero(grid));
        steps.push(Step { coarsening, matrix, field: vec![[0.0; 3]; grid.len()] });
    }
    steps
}

fn cycle(levels: &mut [Level]) {
    let Some((level, coarser)) = levels.split_first_mut() else { return };
    let Level { matrix, smoother, solution, right, product, steps } = level;
    solution.fill([0.0; 3]);
    let Some(next) = coarser.first_mut() else {
        for _ in 0..COARSEST_SWEEPS {
            smoother.sweep(matrix, right, solution, Sweep::Forward);
            smoother.sweep(matrix, right, solution, Sweep::Backward);
        }
        return;
    };
    smoother.sweep(matrix, right, solution, Sweep::Forward);
    matrix.multiply_into(solution, product);
    product.par_iter_mut().zip(right.par_iter()).with_min_len(LEAST_VALUES).for_each(|(product, right)| {
        *product = [0, 1, 2].map(|c| right[c] - product[c]);
    });
    for step in 0..steps.len() {
        let (before, rest) = steps.split_at_mut(step);
        let source = before.last().map_or(&*product, |step| &step.field);
        rest[0].coarsening.restrict_into(source, &mut rest[0].field);
    }
    if let Some(step) = steps.last() {
        next.right.copy_from_slice(&step.field);
    }
    cycle(coarser);
    if let (Some(step), Some(next)) = (steps.last_mut(), coarser.first()) {
        step.field.copy_from_slice(&next.solution);
    }
    for step in (0..steps.len()).rev() {
        let (before, rest) = steps.split_at_mut(step);
        let target = before.last_mut().map_or(&mut *product, |step| &mut step.field);
        rest[0].coarsening.prolong_into(&rest[0].field, target);
    }
    solution.par_iter_mut().zip(product.par_iter()).with_min_len(LEAST_VALUES).for_each(|(solution, correction)| {
        *solution = [0, 1, 2].map(|c| solution[c] + correction[c]);
    });
    smoother.sweep(matrix, right, solution, Sweep::Backward);
}

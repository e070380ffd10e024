//! Newton's method for the gel's rest and the set of touching nodes together.

use super::frame::{Frame, dot};
use super::touch::{Node, Touch};
use super::{Press, StepReport};
use crate::Pose;
use crate::solver::{Grid, OWN, Stencil, column};
use rayon::prelude::*;

/// Residual, over the contact force, at which the gel is at rest, dimensionless.
const TOLERANCE: f64 = 1e-6;
/// Distance from the face at which a touching node lies on it, mm.
const DISTANCE_MM: f64 = 1e-7;
const MOST_ITERATIONS: usize = 40;
/// Residual of a linear solve over its right side, dimensionless, and its most steps.
const LINEAR_TOLERANCE: f64 = 3e-3;
const MOST_LINEAR_ITERATIONS: usize = 200;
/// Residual over the contact force below which friction takes up the present normal forces.
const BALANCED: f64 = 1e-2;
/// Iterations after which friction keeps the normal forces that it took up, and jumping nodes are wedged.
const LATE: usize = 15;
/// A Newton step is shortened until its slope has fallen to this share, at most so often.
const SLOPE_LEFT: f64 = 0.5;
const MOST_SHORTENINGS: usize = 6;
/// Change of the drag forces over the contact force at which sliding has settled.
const DRAG_TOLERANCE: f64 = 1e-5;

/// What a constraint leaves of a node's freedom.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Constraint {
    /// Projector onto the free directions.
    free: [[f64; 3]; 3],
    /// Prescribed motion along the others, mm.
    motion: [f64; 3],
    /// Given force along the free directions, N.
    drag: [f64; 3],
    /// Stiffness added because the face bends, N/mm.
    bend: [[f64; 3]; 3],
}

/// Room for the iteration.
#[derive(Debug)]
pub(super) struct Scratch {
    right: Vec<[f64; 3]>,
    step: Vec<[f64; 3]>,
    trial: Vec<[f64; 3]>,
    forces: Vec<[f64; 3]>,
    single: Vec<[f64; 3]>,
}

impl Scratch {
    pub(super) fn new(grid: Grid) -> Self {
        let field = || vec![[0.0; 3]; grid.len()];
        Self { right: field(), step: field(), trial: field(), forces: field(), single: field() }
    }
}

impl Press<'_> {
    /// Finds the rest at `pose`; whether it was found. If not, the press is as it was.
    pub(super) fn equilibrate(&mut self, pose: &Pose) -> bool {
        let rest = (self.displacement.clone(), self.forces.clone(), self.touches.clone(), self.assembled);
        let found = self.iterate(pose, &rest.0);
        if !found {
            (self.displacement, self.forces, self.touches, self.assembled) = rest;
        }
        found
    }

    fn iterate(&mut self, pose: &Pose, rest: &[[f64; 3]]) -> bool {
        let frames = [self.frame(&self.pose), self.frame(pose)];
        let mut changes = vec![0_u8; self.touches.len()];
        for iteration in 0..MOST_ITERATIONS {
            let Ok(assembled) = self.assembly.tangent_into(&self.displacement, &mut self.forces, &mut self.matrix)
            else {
                return false;
            };
            self.assembled = assembled;
            // The set at the last rest carries the first iteration, if there is one.
            let is_seeding = iteration == 0 && self.touches.iter().all(|touch| *touch == Touch::Free);
            let changed = if iteration > 0 || is_seeding {
                self.update_touches((&frames, rest), &mut changes, iteration)
            } else {
                true
            };
            let constraints = self.constraints(&frames[1]);
            if !changed && self.is_at_rest(&constraints) {
                self.settle_rubs(&frames[1]);
                return true;
            }
            self.report.newton_iterations += 1;
            if !self.newton_step(&frames[1], &constraints) {
                return false;
            }
        }
        false
    }

    /// Asks every surface node what it does; whether any answer changed.
    fn update_touches(
        &mut self,
        (frames, rest): (&[Frame; 2], &[[f64; 3]]),
        changes: &mut [u8],
        iteration: usize,
    ) -> bool {
        let grid = self.assembly.grid;
        let contact_force = self.contact_force();
        let is_balanced =
            iteration < LATE && self.residual_norm(&self.constraints(&frames[1])) <= BALANCED * contact_force;
        let mut changed = false;
        for surface in 0..self.touches.len() {
            let (i, j) = (surface % grid.nodes[0], surface / grid.nodes[0]);
            let index = grid.index(i, j, 0);
            let place = |field: &[[f64; 3]]| {
                let node = self.assembly.mesh.node(i, j, 0);
                [0, 1, 2].map(|c| node[c] + field[index][c])
            };
            let node = Node {
                relief: self.relief,
                law: self.contact,
                frames: [&frames[0], &frames[1]],
                places: [place(rest), place(&self.displacement)],
                force: self.forces[index],
                is_late: iteration >= LATE,
                is_balanced,
                contact_force,
            };
            let touch = self.touches[surface];
            let next = node.next(touch, changes[surface]);
            let is_same = match (touch, next) {
                (Touch::Rubbing(a), Touch::Rubbing(b)) => {
                    let (a, b) = (a.drag(), b.drag());
                    let change = [0, 1, 2].map(|c| a[c] - b[c]);
                    dot(&change, &change).sqrt() <= DRAG_TOLERANCE * contact_force
                }
                (a, b) if std::mem::discriminant(&a) == std::mem::discriminant(&b) => true,
                _ => {
                    changes[surface] = changes[surface].saturating_add(1);
                    false
                }
            };
            changed |= !is_same;
            self.touches[surface] = next;
        }
        changed
    }

    /// Lets the anchors of rubbing nodes follow them.
    fn settle_rubs(&mut self, frame: &Frame) {
        let grid = self.assembly.grid;
        for surface in 0..self.touches.len() {
            if let Touch::Rubbing(rub) = self.touches[surface] {
                let (i, j) = (surface % grid.nodes[0], surface / grid.nodes[0]);
                let (node, moved) = (self.assembly.mesh.node(i, j, 0), self.displacement[grid.index(i, j, 0)]);
                let place = [0, 1, 2].map(|c| node[c] + moved[c]);
                self.touches[surface] = Touch::Rubbing(rub.at_rest(frame, place, self.relief));
            }
        }
    }

    /// Norm of the nodal forces in contact, N.
    fn contact_force(&self) -> f64 {
        let squares = self.touching().map(|(index, _)| dot(&self.forces[index], &self.forces[index]));
        squares.sum::<f64>().sqrt()
    }

    /// Places in the grid of the nodes in touch.
    pub(super) fn touching(&self) -> impl Iterator<Item = (usize, Touch)> {
        let grid = self.assembly.grid;
        let touching = self.touches.iter().enumerate().filter(|(_, touch)| **touch != Touch::Free);
        touching.map(move |(n, touch)| (grid.index(n % grid.nodes[0], n / grid.nodes[0], 0), *touch))
    }

    fn constraints(&self, frame: &Frame) -> Vec<Option<Constraint>> {
        let grid = self.assembly.grid;
        let constraint = |(surface, touch): (usize, &Touch)| {
            let (i, j) = (surface % grid.nodes[0], surface / grid.nodes[0]);
            let (index, node) = (grid.index(i, j, 0), self.assembly.mesh.node(i, j, 0));
            let place = [0, 1, 2].map(|c| node[c] + self.displacement[index][c]);
            match touch {
                Touch::Free => None,
                Touch::Held { anchor } => {
                    let target = frame.gel_from_indenter(*anchor);
                    let motion = [0, 1, 2].map(|c| target[c] - place[c]);
                    Some(Constraint { free: [[0.0; 3]; 3], motion, drag: [0.0; 3], bend: [[0.0; 3]; 3] })
                }
                Touch::Sliding | Touch::Rubbing(_) => {
                    let gap = frame.gap(self.relief, place)?;
                    let n = gap.normal;
                    let push = dot(&self.forces[index], &n).max(0.0);
                    let free = [0, 1, 2].map(|r| [0, 1, 2].map(|c| f64::from(u8::from(r == c)) - n[r] * n[c]));
                    let (drag, rub) = match touch {
                        Touch::Rubbing(rub) => (rub.drag(), rub.stiffness(&free)),
                        _ => ([0.0; 3], [[0.0; 3]; 3]),
                    };
                    let bend = [0, 1, 2].map(|r| [0, 1, 2].map(|c| rub[r][c] - push * gap.curvature[r][c]));
                    Some(Constraint { free, motion: n.map(|value| -gap.distance * value), drag, bend })
                }
            }
        };
        self.touches.iter().enumerate().map(constraint).collect()
    }

    /// Whether forces balance and the touching nodes lie on the face.
    fn is_at_rest(&self, constraints: &[Option<Constraint>]) -> bool {
        let moves = constraints.iter().flatten().map(|constraint| dot(&constraint.motion, &constraint.motion).sqrt());
        if moves.fold(0.0, f64::max) > DISTANCE_MM {
            return false;
        }
        self.residual_norm(constraints) <= TOLERANCE * self.contact_force() + 1e-14
    }

    /// Norm of the forces that nothing balances, N.
    fn residual_norm(&self, constraints: &[Option<Constraint>]) -> f64 {
        let grid = self.assembly.grid;
        let all = crate::solver::dot(grid, &self.forces, &self.forces);
        let constrained = constraints.iter().enumerate().filter_map(|(surface, constraint)| {
            let constraint = constraint.as_ref()?;
            let force = self.forces[grid.index(surface % grid.nodes[0], surface / grid.nodes[0], 0)];
            let rest = [0, 1, 2].map(|c| force[c] - constraint.drag[c]);
            let free = constraint.free.map(|row| dot(&row, &rest));
            Some(dot(&free, &free) - dot(&force, &force))
        });
        (all + constrained.sum::<f64>()).max(0.0).sqrt()
    }

    /// One Newton step; whether there was one that turns no element inside out.
    fn newton_step(&mut self, frame: &Frame, constraints: &[Option<Constraint>]) -> bool {
        let grid = self.assembly.grid;
        add_bend(grid, constraints, &mut self.matrix);
        let Scratch { right, step, trial, single, .. } = &mut self.work;
        single.fill([0.0; 3]);
        for (surface, constraint) in constraints.iter().enumerate() {
            if let Some(constraint) = constraint {
                single[grid.index(surface % grid.nodes[0], surface / grid.nodes[0], 0)] = constraint.motion;
            }
        }
        self.matrix.multiply_into(single, trial);
        right.copy_from_slice(&self.forces);
        apply_drag(grid, constraints, right);
        right.par_iter_mut().zip(trial.par_iter()).for_each(|(right, moved)| {
            *right = [0, 1, 2].map(|c| -right[c] - moved[c]);
        });
        fill_preconditioner(&self.matrix, constraints, self.multigrid.finest_mut());
        self.multigrid.refresh();
        let outcome = self.solver.solve(
            &self.matrix,
            &mut self.multigrid,
            (right, step),
            &|field| project(grid, constraints, field),
            (LINEAR_TOLERANCE, MOST_LINEAR_ITERATIONS),
        );
        self.report.linear_iterations += outcome.iterations;
        self.take_step(frame)
    }

    /// Goes the prescribed motion and so much of the Newton step that the energy along it has no slope left.
    fn take_step(&mut self, frame: &Frame) -> bool {
        let grid = self.assembly.grid;
        let slope = crate::solver::dot(grid, &self.work.right, &self.work.step);
        let (mut share, mut bracket) = (1.0, [(0.0, slope), (f64::NAN, 0.0)]);
        for shortening in 0..=MOST_SHORTENINGS {
            let Scratch { step, trial, forces, single, .. } = &mut self.work;
            let motions = step.par_iter().zip(single.par_iter()).zip(self.displacement.par_iter());
            trial.par_iter_mut().zip(motions).for_each(|(trial, ((step, moved), displacement))| {
                *trial = [0, 1, 2].map(|c| displacement[c] + moved[c] + share * step[c]);
            });
            if self.assembly.forces_into(trial, forces).is_err() {
                share *= 0.5;
                bracket[1] = (f64::NAN, 0.0);
                continue;
            }
            self.take_off_drag(frame);
            let left = -crate::solver::dot(grid, &self.work.forces, &self.work.step);
            if left >= -SLOPE_LEFT * slope && (left <= SLOPE_LEFT * slope || share >= 1.0)
                || shortening == MOST_SHORTENINGS
            {
                std::mem::swap(&mut self.work.trial, &mut self.displacement);
                return true;
            }
            bracket[usize::from(left < 0.0)] = (share, left);
            let [(low, above), (high, below)] = bracket;
            // Regula falsi, kept off the ends.
            let fraction = if high.is_nan() { 0.5 } else { (above / (above - below)).clamp(0.1, 0.9) };
            share = low + fraction * (if high.is_nan() { share } else { high } - low);
        }
        false
    }

    /// Takes the drag at the trial displacement off the trial forces.
    fn take_off_drag(&mut self, frame: &Frame) {
        let grid = self.assembly.grid;
        for (surface, touch) in self.touches.iter().enumerate() {
            if let Touch::Rubbing(rub) = touch {
                let (i, j) = (surface % grid.nodes[0], surface / grid.nodes[0]);
                let (index, node) = (grid.index(i, j, 0), self.assembly.mesh.node(i, j, 0));
                let place = [0, 1, 2].map(|c| node[c] + self.work.trial[index][c]);
                if let Some(gap) = frame.gap(self.relief, place) {
                    let drag = rub.moved_to(frame, &place, &gap.normal).drag();
                    self.work.forces[index] = [0, 1, 2].map(|c| self.work.forces[index][c] - drag[c]);
                }
            }
        }
    }

    /// Writes what the present state came to.
    pub(super) fn finish_report(&mut self) {
        let StepReport { energy_nmm, base_force_n, .. } = &mut self.report;
        (*energy_nmm, *base_force_n) = (self.assembled.energy, self.assembled.base_force);
    }
}

/// Leaves of each constrained node's vector what the constraint leaves free.
fn project(grid: Grid, constraints: &[Option<Constraint>], field: &mut [[f64; 3]]) {
    for (surface, constraint) in constraints.iter().enumerate() {
        if let Some(constraint) = constraint {
            let value = &mut field[grid.index(surface % grid.nodes[0], surface / grid.nodes[0], 0)];
            *value = constraint.free.map(|row| dot(&row, value));
        }
    }
}

/// Takes the given forces off the forces that hold the nodes.
fn apply_drag(grid: Grid, constraints: &[Option<Constraint>], forces: &mut [[f64; 3]]) {
    for (surface, constraint) in constraints.iter().enumerate() {
        if let Some(constraint) = constraint {
            let value = &mut forces[grid.index(surface % grid.nodes[0], surface / grid.nodes[0], 0)];
            *value = [0, 1, 2].map(|c| value[c] - constraint.drag[c]);
        }
    }
}

fn add_bend(grid: Grid, constraints: &[Option<Constraint>], matrix: &mut Stencil<f64>) {
    for (surface, constraint) in constraints.iter().enumerate() {
        if let Some(constraint) = constraint {
            let rows = &mut matrix.rows[grid.index(surface % grid.nodes[0], surface / grid.nodes[0], 0)];
            for (r, c) in (0..9).map(|n| (n / 3, n % 3)) {
                rows[r][OWN + c] += constraint.bend[r][c];
            }
        }
    }
}

/// Writes `P A P + d (I − P)` for the preconditioner, `d` each node's own mean stiffness.
fn fill_preconditioner(matrix: &Stencil<f64>, constraints: &[Option<Constraint>], target: &mut Stencil<f32>) {
    let (grid, slab) = (matrix.grid, matrix.grid.slab());
    let [nx, ny, _] = grid.nodes;
    target.rows.par_iter_mut().zip(matrix.rows.par_iter()).for_each(|(target, rows)| {
        for (target, value) in target.as_flattened_mut().iter_mut().zip(rows.as_flattened()) {
            *target = *value as f32;
        }
    });
    let at = |i: isize, j: isize| {
        let (i, j) = (usize::try_from(i).ok().filter(|i| *i < nx)?, usize::try_from(j).ok().filter(|j| *j < ny)?);
        constraints[j * nx + i].as_ref()
    };
    target.rows[slab..].par_chunks_mut(slab).take(ny).enumerate().for_each(|(j, rows)| {
        // Only the surface and the layer below it reach constrained nodes.
        for (k, i) in (0..2.min(grid.nodes[2])).flat_map(|k| (0..nx).map(move |i| (k, i))) {
            let rows = &mut rows[grid.in_slab(i, k)];
            let stiffness = (rows[0][OWN] + rows[1][OWN + 1] + rows[2][OWN + 2]) / 3.0;
            let (i, j) = (i.cast_signed(), j.cast_signed());
            for (dx, dy) in (0..9).map(|n: isize| (n % 3 - 1, n / 3 - 1)) {
                let Some(constraint) = at(i + dx, j + dy) else { continue };
                let first = column([dx, dy, -k.cast_signed()]);
                for row in rows.iter_mut() {
                    let old = [0, 1, 2].map(|c| row[first + c]);
                    for c in 0..3 {
                        row[first + c] = (0..3).map(|m| old[m] * constraint.free[m][c] as f32).sum();
                    }
                }
            }
            if k == 0
                && let Some(constraint) = at(i, j)
            {
                let free = constraint.free.map(|row| row.map(|value| value as f32));
                for c in 0..rows[0].len() {
                    let old = [rows[0][c], rows[1][c], rows[2][c]];
                    for r in 0..3 {
                        rows[r][c] = (0..3).map(|m| free[r][m] * old[m]).sum();
                    }
                }
                for (r, c) in (0..9).map(|n| (n / 3, n % 3)) {
                    rows[r][OWN + c] += stiffness * (f32::from(u8::from(r == c)) - free[r][c]);
                }
            }
        }
    });
}

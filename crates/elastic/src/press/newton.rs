//! Newton's method for the gel's equilibrium and the set of touching nodes together.

use super::constraint::{Constraint, add_stiffness, apply_drag, constrain, project};
use super::frame::{Frame, dot};
use super::touch::{Node, Touch, below};
use super::{Advance, ContinueCheck, Press, PressError, StepReport};
use crate::solver::{Field, Grid, Outcome, Stop};
use crate::{ContactLaw, Pose};

/// Residual, over the contact force, at which the gel is in equilibrium, dimensionless.
const TOLERANCE: f64 = 3e-6;
/// Distance from the face at which a touching node counts as lying on it, mm.
const DISTANCE_MM: f64 = 1e-7;
const MOST_ITERATIONS: usize = 40;
/// Residual of a linear solve over its right side, dimensionless, and its most steps.
const LINEAR_TOLERANCE: f64 = 1e-3;
const MOST_LINEAR_ITERATIONS: usize = 200;
/// A solve ends when it reaches this share of the equilibrium residual, even if its relative residual is larger.
const GOAL_SHARE: f64 = 0.3;
/// Residual over the contact force below which friction uses the current normal forces.
const BALANCED: f64 = 1e-2;
/// Iterations after which friction keeps its normal forces, and nodes that keep jumping are fixed.
const LATE: usize = 15;
/// A Newton step is shortened until its slope has fallen to this share; at most this many lengths are tried.
const SLOPE_LEFT: f64 = 0.5;
const MOST_TRIALS: usize = 12;
/// Factor by which a step is lengthened at once where the gel is about to snap, and the largest motion of a node in it,
/// mm.
const LENGTHENING: f64 = 8.0;
const SNAP_MM: f64 = 0.2;
/// Change of the friction forces over the contact force at which sliding has converged.
const DRAG_TOLERANCE: f64 = 1e-5;

/// Scratch memory for the iteration.
#[derive(Debug)]
pub(super) struct Scratch {
    right: Vec<[f64; 3]>,
    step: Vec<[f64; 3]>,
    trial: Vec<[f64; 3]>,
    forces: Vec<[f64; 3]>,
    /// Prescribed motion, and its reaction forces.
    motion: Vec<[f32; 3]>,
    moved: Vec<[f32; 3]>,
}

impl Scratch {
    pub(super) fn new(grid: Grid) -> Self {
        let field = || vec![[0.0; 3]; grid.len()];
        let single = || vec![[0.0; 3]; grid.len()];
        Self { right: field(), step: field(), trial: field(), forces: field(), motion: single(), moved: single() }
    }
}

impl Press<'_> {
    /// Finds the equilibrium at `pose`; returns whether it was found. If not, the press is unchanged.
    ///
    /// # Errors
    ///
    /// [`PressError::Stopped`] if `should_continue` says so.
    pub(super) fn equilibrate(&mut self, pose: &Pose, should_continue: ContinueCheck) -> Result<bool, PressError> {
        let rest = (self.displacement.clone(), self.forces.clone(), self.touches.clone(), self.assembled);
        self.predict(pose);
        let found = self.iterate(pose, &rest.0, should_continue);
        if found == Ok(true) {
            let change = self.displacement.iter().zip(&rest.0).map(|(now, then)| [0, 1, 2].map(|c| now[c] - then[c]));
            self.last = Some(Advance { poses: [self.pose, *pose], displacement: change.collect() });
            self.pose = *pose;
        } else {
            (self.displacement, self.forces, self.touches, self.assembled) = rest;
            self.last = None;
        }
        found
    }

    /// Starts from the extrapolation of the last part, provided that the indenter's motion continues.
    fn predict(&mut self, pose: &Pose) {
        let Some(Advance { poses, displacement }) = &self.last else { return };
        let Some(share) = poses[0].share_of_way(&poses[1], &self.pose, pose) else { return };
        let Scratch { trial, forces, .. } = &mut self.work;
        for ((trial, now), change) in trial.iter_mut().zip(&self.displacement).zip(displacement) {
            *trial = [0, 1, 2].map(|c| now[c] + share * change[c]);
        }
        if let Ok(assembled) = self.assembly.forces_into(trial, forces) {
            std::mem::swap(trial, &mut self.displacement);
            std::mem::swap(forces, &mut self.forces);
            self.assembled = assembled;
        }
    }

    fn iterate(&mut self, pose: &Pose, rest: &[[f64; 3]], should_continue: ContinueCheck) -> Result<bool, PressError> {
        let frames = [self.frame(&self.pose), self.frame(pose)];
        let mut changes = vec![0_u8; self.touches.len()];
        for iteration in 0..MOST_ITERATIONS {
            if should_continue().is_break() {
                return Err(PressError::Stopped);
            }
            // The contact set of the last equilibrium supports the first iteration, if there is one.
            let is_seeding = iteration == 0 && self.touches.iter().all(|touch| *touch == Touch::Free);
            let changed = if iteration > 0 || is_seeding {
                self.update_touches((&frames, rest), &mut changes, iteration)
            } else {
                true
            };
            let constraints = self.constraints(&frames[1]);
            if !changed && self.is_at_rest(&constraints) {
                self.move_anchors(&frames[1]);
                return Ok(true);
            }
            self.report.newton_iterations += 1;
            if !self.newton_step(&frames[1], &constraints) {
                return Ok(false);
            }
        }
        Ok(false)
    }

    /// Updates the contact state of every surface node; returns whether any changed.
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
            let node = Node {
                relief: self.relief,
                law: self.contact,
                frames: [&frames[0], &frames[1]],
                places: [self.place(surface, rest), self.place(surface, &self.displacement)],
                force: self.forces[grid.on_surface(surface)],
                is_late: iteration >= LATE,
                is_balanced,
                contact_force,
            };
            let touch = self.touches[surface];
            let next = node.next(touch, changes[surface]);
            let is_same = match (touch, next) {
                (Touch::Frictional(a), Touch::Frictional(b)) => {
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

    /// Moves the anchors of sliding nodes with them.
    fn move_anchors(&mut self, frame: &Frame) {
        for surface in 0..self.touches.len() {
            if let Touch::Frictional(friction) = self.touches[surface] {
                let place = self.place(surface, &self.displacement);
                self.touches[surface] = Touch::Frictional(friction.at_rest(frame, place, self.relief));
            }
        }
    }

    /// Holds the nodes that slid in the last step, where the contact sticks late.
    pub(super) fn hold_late(&mut self) {
        if self.contact != ContactLaw::LateStick {
            return;
        }
        let frame = self.frame(&self.pose);
        for surface in 0..self.touches.len() {
            if self.touches[surface] == Touch::Sliding {
                let place = self.place(surface, &self.displacement);
                self.touches[surface] = Touch::Held { anchor: below(&frame, self.relief, place) };
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
        touching.map(move |(surface, touch)| (grid.on_surface(surface), *touch))
    }

    /// Position of a surface node under a displacement, mm.
    pub(super) fn place(&self, surface: usize, displacement: &[[f64; 3]]) -> [f64; 3] {
        let grid = self.assembly.grid;
        let node = self.assembly.mesh.node(surface % grid.nodes[0], surface / grid.nodes[0], 0);
        let moved = displacement[grid.on_surface(surface)];
        [0, 1, 2].map(|c| node[c] + moved[c])
    }

    /// Whether forces balance and the touching nodes lie on the face.
    fn is_at_rest(&self, constraints: &[Option<Constraint>]) -> bool {
        let moves = constraints.iter().flatten().map(|constraint| dot(&constraint.motion, &constraint.motion).sqrt());
        if moves.fold(0.0, f64::max) > DISTANCE_MM {
            return false;
        }
        self.residual_norm(constraints) <= TOLERANCE * self.contact_force() + 1e-14
    }

    /// Norm of the unbalanced forces, N.
    fn residual_norm(&self, constraints: &[Option<Constraint>]) -> f64 {
        let grid = self.assembly.grid;
        let all = crate::solver::dot(grid, &self.forces, &self.forces);
        let constrained = constraints.iter().enumerate().filter_map(|(surface, constraint)| {
            let constraint = constraint.as_ref()?;
            let force = self.forces[grid.on_surface(surface)];
            let rest = [0, 1, 2].map(|c| force[c] - constraint.drag[c]);
            let free = constraint.free.map(|row| dot(&row, &rest));
            Some(dot(&free, &free) - dot(&force, &force))
        });
        (all + constrained.sum::<f64>()).max(0.0).sqrt()
    }

    /// One Newton step; returns whether there was one that turns no element inside out.
    fn newton_step(&mut self, frame: &Frame, constraints: &[Option<Constraint>]) -> bool {
        // A node on a sharp fillet may be about to snap off: without the bend, the step still reduces the energy.
        let mut most_share = 1.0;
        for is_bent in [true, false] {
            if self.assembly.tangent_into(&self.displacement, self.multigrid.finest_mut()).is_err() {
                return false;
            }
            if !self.solve_step(constraints, is_bent).is_indefinite {
                break;
            }
            most_share = f64::INFINITY;
        }
        if most_share > 1.0 {
            // Near an unstable equilibrium the step is tiny, and the growing mode must leave it.
            let longest = self.work.step.iter().map(|step| dot(step, step)).fold(0.0, f64::max).sqrt();
            most_share = (SNAP_MM / longest).max(1.0);
        }
        self.take_step(frame, constraints, most_share)
    }

    /// Solves for the step with the current tangent matrix, with or without the contribution of the bent face.
    fn solve_step(&mut self, constraints: &[Option<Constraint>], is_bent: bool) -> Outcome {
        let grid = self.assembly.grid;
        add_stiffness(grid, constraints, is_bent, self.multigrid.finest_mut());
        let Scratch { right, motion, moved, .. } = &mut self.work;
        motion.fill([0.0; 3]);
        for (surface, constraint) in constraints.iter().enumerate() {
            if let Some(constraint) = constraint {
                motion[grid.on_surface(surface)] = constraint.motion.map(|value| value as f32);
            }
        }
        self.multigrid.finest().multiply_into(motion, moved);
        right.copy_from_slice(&self.forces);
        apply_drag(grid, constraints, right);
        for (right, moved) in right.iter_mut().zip(moved.iter()) {
            *right = [0, 1, 2].map(|c| -right[c] - f64::from(moved[c]));
        }
        constrain(self.multigrid.finest_mut(), constraints);
        self.multigrid.refresh();
        let stop = Stop {
            goal: GOAL_SHARE * TOLERANCE * self.contact_force(),
            tolerance: LINEAR_TOLERANCE,
            limit: MOST_LINEAR_ITERATIONS,
        };
        let Scratch { right, step, .. } = &mut self.work;
        let project = |field: &mut Field<f32>| project(grid, constraints, field);
        let outcome = self.solver.solve(&mut self.multigrid, (right, step), &project, stop);
        self.report.linear_iterations += outcome.iterations;
        outcome
    }

    /// Applies the prescribed motion and the part of the Newton step at which the energy along it has zero slope.
    ///
    /// The step is lengthened up to `most_share` while the energy still falls.
    fn take_step(&mut self, frame: &Frame, constraints: &[Option<Constraint>], most_share: f64) -> bool {
        let slope = crate::solver::dot(self.assembly.grid, &self.work.right, &self.work.step);
        let (mut share, mut bracket) = (1.0, [(0.0, slope), (f64::NAN, 0.0)]);
        for trial_number in 0..=MOST_TRIALS {
            let Scratch { step, trial, forces, motion, .. } = &mut self.work;
            let motions = step.iter().zip(motion.iter()).zip(&self.displacement);
            for (trial, ((step, motion), displacement)) in trial.iter_mut().zip(motions) {
                *trial = [0, 1, 2].map(|c| displacement[c] + f64::from(motion[c]) + share * step[c]);
            }
            let Ok(assembled) = self.assembly.forces_into(trial, forces) else {
                share *= 0.5;
                bracket[1] = (f64::NAN, 0.0);
                continue;
            };
            let left = self.slope_at_trial(frame, constraints);
            if left > SLOPE_LEFT * slope && share >= 1.0 && LENGTHENING * share <= most_share && bracket[1].0.is_nan() {
                bracket[0] = (share, left);
                share *= LENGTHENING;
                continue;
            }
            if left >= -SLOPE_LEFT * slope && (left <= SLOPE_LEFT * slope || share >= 1.0)
                || trial_number == MOST_TRIALS
            {
                std::mem::swap(&mut self.work.trial, &mut self.displacement);
                std::mem::swap(&mut self.work.forces, &mut self.forces);
                self.assembled = assembled;
                return true;
            }
            bracket[usize::from(left < 0.0)] = (share, left);
            let [(low, above), (high, below)] = bracket;
            // Regula falsi, kept away from the ends.
            let fraction = if high.is_nan() { 0.5 } else { (above / (above - below)).clamp(0.1, 0.9) };
            share = low + fraction * (if high.is_nan() { share } else { high } - low);
        }
        false
    }

    /// Slope of the energy along the step at the trial displacement, N mm.
    ///
    /// The face bends away from a straight step. The energy gained by following it is the work of the current normal
    /// force along the step with the normal at the trial place.
    fn slope_at_trial(&self, frame: &Frame, constraints: &[Option<Constraint>]) -> f64 {
        let Scratch { step, trial, forces, .. } = &self.work;
        let mut slope = -crate::solver::dot(self.assembly.grid, forces, step);
        for (surface, touch) in self.touches.iter().enumerate() {
            if let (Touch::Sliding | Touch::Frictional(_), Some(constraint)) = (touch, &constraints[surface]) {
                let (along, place) = (&step[self.assembly.grid.on_surface(surface)], self.place(surface, trial));
                let Some(gap) = frame.gap(self.relief, place) else { continue };
                slope += constraint.push * dot(&gap.normal, along);
                if let Touch::Frictional(friction) = touch {
                    slope += dot(&friction.moved_to(frame, &place, &gap.normal).drag(), along);
                }
            }
        }
        slope
    }

    /// Writes the result of the current state.
    pub(super) fn finish_report(&mut self) {
        let StepReport { energy_nmm, base_force_n, .. } = &mut self.report;
        (*energy_nmm, *base_force_n) = (self.assembled.energy, self.assembled.base_force);
    }
}

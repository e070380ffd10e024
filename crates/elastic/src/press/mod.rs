//! A rigid indenter pressed into the gel, step by step.
//!
//! Contact is node against surface and exact: where a node touches, its displacement along the indenter's normal (and
//! along the surface, where it sticks) is prescribed, and the reaction is the contact force. The set of touching nodes
//! is found together with the displacement: a node that would penetrate is added, one that would have to be pulled is
//! released ([Hueeber2005]). Between nodes the surface may penetrate the indenter's edges by less than a cell resolves.

mod constraint;
mod error;
mod frame;
mod newton;
mod region;
mod surface;
#[cfg(test)]
mod tests;
mod touch;

pub use error::PressError;
pub use region::{MeshParams, Resolution, SweptRegion, swept_region};

use std::ops::ControlFlow;

use crate::fem::{Assembled, Assembly, BlockMesh, Material};
use crate::solver::{Multigrid, Solver};
use crate::{ContactLaw, GelBlock, Law, Pose, Relief, SurfaceState};
use frame::Frame;
use touch::Touch;

/// Largest number of times that a step is halved.
const MOST_HALVINGS: u32 = 6;

/// Called repeatedly while a step is solved; returns whether to continue.
pub type ContinueCheck<'a> = &'a mut (dyn FnMut() -> ControlFlow<()> + Send);

/// The gel and the contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PressSetup {
    /// The gel.
    pub block: GelBlock,
    /// Its material law.
    pub law: Law,
    /// The contact law.
    pub contact: ContactLaw,
}

/// The outcome of a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StepReport {
    /// Newton iterations, summed over all parts of the step.
    pub newton_iterations: usize,
    /// Conjugate-gradient iterations.
    pub linear_iterations: usize,
    /// Number of parts into which the step was divided.
    pub parts: usize,
    /// Strain energy, N mm.
    pub energy_nmm: f64,
    /// Force of the base on the gel, N.
    pub base_force_n: [f64; 3],
}

/// A motion of the indenter and the resulting displacement of the gel.
#[derive(Debug)]
struct Advance {
    poses: [Pose; 2],
    displacement: Vec<[f64; 3]>,
}

/// A block of gel under an indenter.
pub struct Press<'a> {
    relief: &'a dyn Relief,
    centre_mm: [f64; 2],
    contact: ContactLaw,
    assembly: Assembly,
    multigrid: Multigrid,
    solver: Solver,
    work: newton::Scratch,
    /// Current state; while a step is solved, the result of its last converged part.
    displacement: Vec<[f64; 3]>,
    forces: Vec<[f64; 3]>,
    touches: Vec<Touch>,
    pose: Pose,
    /// The outcome of the last part of a step, if the press has moved.
    last: Option<Advance>,
    assembled: Assembled,
    state: SurfaceState,
    report: StepReport,
}

impl std::fmt::Debug for Press<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Press").field("pose", &self.pose).field("report", &self.report).finish_non_exhaustive()
    }
}

impl<'a> Press<'a> {
    /// A block at rest, with an indenter above `centre_mm` that just touches it.
    ///
    /// # Errors
    ///
    /// [`PressError::Block`] or [`PressError::Friction`] if the setup is impossible.
    pub fn new(
        setup: &PressSetup,
        mesh: BlockMesh,
        relief: &'a dyn Relief,
        centre_mm: [f64; 2],
    ) -> Result<Self, PressError> {
        setup.block.validate()?;
        if let ContactLaw::Friction(coefficient) = setup.contact
            && !(coefficient.is_finite() && coefficient > 0.0)
        {
            return Err(PressError::Friction { coefficient });
        }
        let base = mesh.lines()[2].last().copied().unwrap_or_default();
        let lines = mesh.lines();
        let multigrid = Multigrid::new([lines[0], lines[1], &lines[2][..lines[2].len() - 1]], base);
        let assembly = Assembly::new(mesh, Material::of(&setup.block, setup.law));
        let grid = assembly.grid;
        let [nx, ny, _] = grid.nodes;
        let field = || vec![[0.0; 3]; grid.len()];
        let mut press = Self {
            relief,
            centre_mm,
            contact: setup.contact,
            multigrid,
            solver: Solver::new(grid),
            work: newton::Scratch::new(grid),
            displacement: field(),
            forces: field(),
            touches: vec![Touch::Free; nx * ny],
            pose: Pose::default(),
            last: None,
            assembled: Assembled::default(),
            state: SurfaceState::default(),
            report: StepReport::default(),
            assembly,
        };
        press.write_state();
        Ok(press)
    }

    /// Moves the indenter from its current pose to `pose` and finds the gel's new equilibrium.
    ///
    /// A step that does not converge is halved, repeatedly. After an error the press is in the last converged state.
    ///
    /// # Errors
    ///
    /// [`PressError::Stalled`] with the depth that was reached, [`PressError::Pose`] for a pose that is not finite.
    pub fn step(&mut self, pose: &Pose) -> Result<&SurfaceState, PressError> {
        self.step_while(pose, &mut || ControlFlow::Continue(()))
    }

    /// The same, but it can be stopped: `should_continue` is called before every Newton iteration. If it is stopped,
    /// the press is in the last converged state.
    ///
    /// # Errors
    ///
    /// As [`Press::step`], and [`PressError::Stopped`].
    pub fn step_while(&mut self, pose: &Pose, should_continue: ContinueCheck) -> Result<&SurfaceState, PressError> {
        if !pose.is_finite() {
            return Err(PressError::Pose { pose: *pose });
        }
        // Within the pool, a task costs little.
        let advanced = rayon::scope(|_| self.advance(pose, should_continue));
        self.write_state();
        advanced?;
        Ok(&self.state)
    }

    fn advance(&mut self, pose: &Pose, should_continue: ContinueCheck) -> Result<(), PressError> {
        self.report = StepReport::default();
        self.hold_late();
        let (from, mut reached, mut halvings) = (self.pose, 0.0, 0_u32);
        while reached < 1.0 {
            let share = 0.5_f64.powi(halvings.cast_signed());
            let target = if reached + share >= 1.0 { *pose } else { from.towards(pose, reached + share) };
            self.report.parts += 1;
            if self.equilibrate(&target, should_continue)? {
                reached += share;
                // The difficult part may be over.
                halvings = halvings.saturating_sub(1);
            } else if halvings == MOST_HALVINGS {
                return Err(PressError::Stalled { reached_mm: self.pose.depth_mm, asked_mm: pose.depth_mm });
            } else {
                halvings += 1;
            }
        }
        Ok(())
    }

    /// The current surface.
    #[must_use]
    pub fn surface(&self) -> &SurfaceState {
        &self.state
    }

    /// The outcome of the last step.
    #[must_use]
    pub fn report(&self) -> StepReport {
        self.report
    }

    fn frame(&self, pose: &Pose) -> Frame {
        Frame::new(pose, self.centre_mm)
    }
}

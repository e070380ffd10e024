//! Solves `A x = b` on a structured grid: conjugate gradients, preconditioned by one cycle of geometric multigrid.
//!
//! The coarse matrices are Galerkin products `Iᵀ A I`, taken one axis at a time, so that every level keeps the 27-node
//! stencil whatever the mesh's grading ([Trottenberg2001]). The preconditioner works in single precision, the conjugate
//! gradients in double. Sums run over slabs in a fixed order: the result does not depend on the number of threads.

mod coarsen;
mod conjugate_gradients;
mod grid;
mod multigrid;
mod smoother;
mod stencil;

use std::ops::{Add, Mul, Sub};

pub(crate) use conjugate_gradients::{Solver, dot};
pub(crate) use grid::Grid;
pub(crate) use multigrid::Multigrid;
pub(crate) use stencil::{OWN, Rows, Stencil, column};

/// A vector of three components at every node of a [`Grid`].
pub(crate) type Field<T> = [[T; 3]];

/// `f32` or `f64`.
pub(crate) trait Real:
    Copy + Send + Sync + PartialOrd + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
    const ZERO: Self;
}

impl Real for f32 {
    const ZERO: Self = 0.0;
}

impl Real for f64 {
    const ZERO: Self = 0.0;
}

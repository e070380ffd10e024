//! Solves `A x = b` on a structured grid: conjugate gradients, preconditioned by one cycle of geometric multigrid.
//!
//! The coarse matrices are Galerkin products `Iᵀ A I`, taken one axis at a time, so that every level keeps the 27-node
//! stencil whatever the mesh's grading ([Trottenberg2001]). All of it is in single precision: for more accuracy, solve
//! again for the residual. Sums run over slabs in a fixed order: the result does not depend on the number of threads.

mod coarsen;
mod conjugate_gradients;
mod grid;
mod multigrid;
mod smoother;
mod stencil;

pub(crate) use conjugate_gradients::{Outcome, Solver, Stop, dot};
pub(crate) use grid::Grid;
pub(crate) use multigrid::Multigrid;
pub(crate) use stencil::{OWN, Rows, Stencil, column};

/// A vector of three components at every node of a [`Grid`].
pub(crate) type Field<T> = [[T; 3]];

//! The compliance of an elastic layer: the displacement of its surface under traction.
//!
//! A layer of infinite extent along x and y, bonded at its base `z = thickness`, isotropic, small strain. Traction is the
//! force on the gel per mm² of the undeformed surface `z = 0`, pressing +z. A wave of traction `t e^{i k·x}` causes a
//! wave of displacement `U(k) t e^{i k·x}`. Along the wave (∥), across it (⊥) and in depth (z), with `k = |k|`:
//!
//! ```text
//! u_∥ = L t_∥ + i C t_z        u_z = N t_z − i C t_∥        u_⊥ = S t_⊥
//! ```
//!
//! They follow from the equations of Navier, `μ u_∥″ − (λ + 2μ) k² u_∥ + i k (λ + μ) u_z′ = 0` and
//! `(λ + 2μ) u_z″ − μ k² u_z + i k (λ + μ) u_∥′ = 0`, with `u = 0` at the base and the traction at the surface. With
//! `q = k · thickness`, `κ = 3 − 4ν` and `D = 2κ cosh 2q + κ² + 1 + 4q²`:
//!
//! ```text
//! μ k L = (1 − ν) (2κ sinh 2q + 4q) / D        μ k N = (1 − ν) (2κ sinh 2q − 4q) / D
//! μ k C = (2 (1 − 2ν) κ sinh² q − 2q²) / D     μ k S = tanh q
//! ```
//!
//! N is that of a frictionless indenter on a bonded layer: K. L. Johnson, *Contact mechanics* (1985), §5.8. The limit of
//! long waves is a uniform layer, `L = S = thickness / μ`, `N = thickness / (λ + 2μ)`, `C = 0`. The limit of short ones
//! is the half-space of Boussinesq and Cerruti (Johnson §3.2, §3.6): `1 − ν`, `1 − ν`, `(1 − 2ν) / 2` and 1 on the right.
//!
//! [`Layer`] gives these at a wavenumber. [`LayerOperator`] applies them to tractions on a grid of cells, with uniform
//! traction in each cell and displacements at the cells' centres. [`BlockOperator`] adds the effect of the free sides
//! of a block. All of this is linear: beyond about 10 % of strain the finite elements are needed.

mod compliance;
#[cfg(test)]
mod contact;
mod grid;
mod half_space;
mod operator;
mod remainder;
mod sides;
mod symbol;
#[cfg(test)]
mod tests;
mod transform;

pub use compliance::{Layer, LayerError, WaveCompliance};
#[cfg(test)]
pub(crate) use contact::{ContactParams, LayerContact, LayerPress};
pub use grid::SurfaceGrid;
pub use operator::LayerOperator;
pub use sides::BlockOperator;

//! Hexahedral finite elements of a block, eight nodes each, with mean dilatation.
//!
//! The volume's part of the energy sees an element's mean volume ratio only (mean dilatation, [Nagtegaal1974], [Bonet2008]), so that a
//! nearly incompressible gel does not lock.
//!
//! That leaves an element free to swell at one end and shrink at the other. Beside a concentrated pressure, as at the rim of a face
//! without friction, it does: a row of surface cells widens, its neighbours shrink, and deeper in the face folds into a zigzag as
//! wide as a cell, which no finer mesh removes and elements without mean dilatation do not show. A term in what is uneven in the volume
//! ends that, as stabilising energies do for other mean-strain elements ([Krysl2015]); it grows with the fourth power, so that small
//! strains and the order of convergence are as without it.

mod assembly;
mod element;
mod material;
mod mesh;
#[cfg(test)]
mod tests;
mod volume;

pub(crate) use assembly::{Assembled, Assembly};
pub(crate) use element::{Stiffness, stiffness};
pub(crate) use material::Material;
pub use mesh::{BlockMesh, graded_lines};

//! Hexahedral finite elements of a block, eight nodes each, with mean dilatation.
//!
//! The volume's part of the energy sees an element's mean volume ratio only (mean dilatation, [Nagtegaal1974], [Bonet2008]), so that a
//! nearly incompressible gel does not lock.

mod assembly;
mod element;
mod material;
mod mesh;
#[cfg(test)]
mod tests;

pub(crate) use assembly::{Assembled, Assembly};
pub(crate) use element::{Stiffness, stiffness};
pub(crate) use material::Material;
pub use mesh::{BlockMesh, graded_lines};

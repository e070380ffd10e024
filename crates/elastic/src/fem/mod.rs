//! Hexahedral finite elements of a block, eight nodes each, with mean dilatation.
//!
//! The volumetric part of the energy depends only on an element's mean volume ratio (mean dilatation, [Nagtegaal1974],
//! [Bonet2008]), so that a nearly incompressible gel does not lock.
//!
//! With mean dilatation alone, an element can expand at one end and shrink at the other. Beside a concentrated pressure,
//! as at the rim of a face without friction, it does: a row of surface cells widens, its neighbours shrink, and at larger
//! depth the face folds into a zigzag as wide as a cell. A finer mesh does not remove it, and elements without mean
//! dilatation do not show it. A term that depends on the unevenness of the volume prevents this, as stabilising energies
//! do for other mean-strain elements ([Krysl2015]); it grows with the fourth power, so that small strains and the order
//! of convergence do not change.

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

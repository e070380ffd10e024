//! The inputs for the colours of a picture.

use super::cells::CellTable;
use super::lattice::Lattice;
use super::patches::Patches;
use super::raster::Planes;

/// The inputs for the colours of parts.
pub(crate) struct ColourInputs<'a> {
    pub(crate) lattice: Lattice,
    pub(crate) planes: &'a Planes,
    pub(crate) cells: &'a CellTable,
    pub(crate) patches: &'a Patches,
    pub(crate) background: [f32; 3],
}

//! Rigid indenters: their description in a scene, and their shape for the mechanics.
//!
//! A flat face has the given size; outside it, at the distance `d`, the body falls off by a fillet of radius `r` and a
//! wall of slope `s`: `h = r − √(r² − d²)` until the slope is `s`, then straight. Inside a hole the distance is that to
//! the hole's rim. A sphere is `h = R − √(R² − ρ²)`, also straight from where its slope is `s`.
//!
//! A height map and a mesh are sampled on a fine grid. Their slopes are limited to `s` too: a steeper wall is made to
//! lean outwards from its upper edge, which fills narrow grooves. Their edges, both convex and concave, are rounded
//! over the fillet's width, half of it on each side.
//!
//! The indenter's frame is gel space moved to the indenter: x right and y down in the image, z towards the camera. Shapes
//! are centred at its origin, except the points of a polygon and the centres of pins, which are used as given.

mod check;
mod error;
mod face;
mod grid;
mod height_field;
mod height_map;
mod letter;
mod mesh;
mod nearest;
mod outline;
mod profile;
mod relief;
mod segments;
mod shape;
mod table;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod tests_of_files;

pub use error::IndenterError;
pub use relief::IndenterRelief;
pub use shape::{Indenter, IndenterShape};

use std::path::Path;

/// All bytes of an indenter's file.
fn read(file: &Path) -> Result<Vec<u8>, IndenterError> {
    std::fs::read(file).map_err(|error| IndenterError::Read { file: file.to_owned(), kind: error.kind() })
}

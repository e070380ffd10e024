//! Patterns for the gel: their description, texture for rendering, and printed page.

mod colour;
mod description;
mod disc;
mod discs;
mod error;
mod print;
mod table;
mod texture;
mod trackability;

pub use colour::{ColourPattern, NEIGHBOUR_DISTANCE};
pub use description::{Motif, Pattern};
pub use error::PatternError;
pub use print::{Paper, Print};
pub use texture::Texture;
pub use trackability::{Coupling, Trackability, View, trackability};

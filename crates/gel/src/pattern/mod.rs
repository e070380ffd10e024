//! Patterns: what is printed on the gel, as a description, as a texture to render and as a page to print.

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

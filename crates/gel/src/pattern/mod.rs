//! Patterns: what is printed on the gel, as a description, as a texture to render and as a page to print.

mod colour;
mod texture;

pub use colour::{ColourPattern, NEIGHBOUR_DISTANCE};
pub use texture::Texture;

//! The exact truth of a frame, on the reference grid.

mod located;
mod projector;

pub use projector::{Truth, TruthProjector};

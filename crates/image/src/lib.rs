//! Pixels: the owned image, the frame that a source provides, and the operations that every stage needs.
//!
//! Integer coordinates are pixel centres, `(x, y)` in that order, x right, y down; storage is row-major
//! `[row][column]`. Nothing here depends on a sensor or a file format.
//!
//! Grey levels are `f32` on the 8-bit scale, 0 to 255, whatever the frame's own depth: a 16-bit value `v` reads
//! `v / 257`.

mod between;
mod colour;
mod colour_detail;
mod error;
mod frame;
mod grid;
mod pyramid;
mod rect;

pub use between::Between;
pub use colour::{LUMA_WEIGHTS, grey_and_channels_into, grey_into};
pub use error::ImageError;
pub use frame::{Frame, Pixels};
pub use grid::Image;
pub use pyramid::{Pyramid, average_into, halve_into};
pub use rect::Rect;

//! Frames in: whatever takes the pictures, every command reads it through [`Source`].
//!
//! [`open`] looks at what lies at a path and picks the reader:
//!
//! - A **folder of images**: PNG, JPEG, TIFF and BMP, one frame a file, in natural order (`frame2` before `frame10`).
//!   Grey and colour, 8 and 16 bit, are kept as they are stored; floating-point TIFF must lie in 0 to 1 and becomes
//!   16 bit. A palette reads as colour, transparency is dropped. The time of a frame is nominal: its number over
//!   [`Options::frames_per_second`].
//!
//! Pictures are turned upright where the file says that the camera was held sideways.

mod error;
mod folder;
mod format;
mod jpeg;
mod natural;
mod open;
mod picture;
mod source;

pub use error::SourceError;
pub use format::FrameFormat;
pub use open::open;
pub use source::{Options, Source};

//! A flat sheet of pattern seen straight on, moved by an analytic [`Motion`]: frames whose flow is exact by construction.

mod motion;
mod params;
mod render;

pub use motion::{Motion, TrueFlow};
pub use params::Sheet;
pub use render::{Light, SheetRenderer};

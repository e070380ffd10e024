//! Renders the deformed surface: computes an 8-bit frame from a state of the gel.
//!
//! The order is the physical one: the nearest surface along every ray, the pattern's exact coverage, the light on the
//! slope, the optics' blur, the pixel's area, vignetting, noise, rounding.

mod cells;
mod error;
mod frame;
mod lattice;
mod light;
mod node;
mod noise;
mod params;
mod parts;
mod patch;
mod patches;
mod raster;
mod samples;
mod sensor;
mod sight;
mod surface;
#[cfg(test)]
mod tests;

pub use error::RenderError;
pub use frame::FrameRenderer;
pub(crate) use lattice::{Lattice, bulge_px};
pub use params::{MotionBlur, RenderParams, RingLight};
pub(crate) use patches::Patches;
pub(crate) use surface::{Instant, Surface, check, widest_mm};

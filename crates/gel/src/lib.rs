//! The simulated sensor: images of a moving colour pattern **with exact truth**.
//!
//! A [`Sheet`] says what the camera sees at rest, a [`Motion`] where every point of it goes. [`SheetRenderer`] draws the
//! frame: every quarter of a pixel is the area-weighted mean of the pattern cells that it covers, then optics blur it,
//! pixels collect it, light scales it, noise falls on it and it is rounded to 8 bits. [`Motion::flow`] is the
//! displacement that a tracker should find, exact by construction.
//!
//! Coordinates are image px: x right, y down, integer = pixel centre. A point at `x` in the reference lies at
//! `x + displacement(x)` in the current image.
//!
//! ```
//! use fingervision_gel::{Light, Motion, Sheet, SheetRenderer};
//!
//! let sheet = Sheet { width: 64, height: 48, ..Sheet::default() };
//! let motion = Motion::shift(5.0);
//! let renderer = SheetRenderer::new(&sheet)?;
//! let reference = renderer.render(&Motion::STILL, Light::EVEN, 1)?;
//! let current = renderer.render(&motion, Light::EVEN, 2)?;
//! let truth = motion.flow(sheet.width, sheet.height);
//! # assert_eq!((reference.size(), current.size(), truth.u.size()), ((64, 48), (64, 48), (64, 48)));
//! # Ok::<(), fingervision_gel::GelError>(())
//! ```

mod blur;
mod coverage;
mod error;
mod indenter;
mod pattern;
mod polygon;
mod render;
mod sheet;
mod truth;

pub use error::GelError;
pub use indenter::{Indenter, IndenterError, IndenterRelief, IndenterShape};
pub use pattern::{
    ColourPattern, Coupling, Motif, NEIGHBOUR_DISTANCE, Pattern, PatternError, Print, Texture, Trackability, View,
    trackability,
};
pub use render::{FrameRenderer, MotionBlur, RenderError, RenderParams, RingLight};
pub use sheet::{Light, Motion, Sheet, SheetRenderer, TrueFlow};
pub use truth::{Truth, TruthProjector};

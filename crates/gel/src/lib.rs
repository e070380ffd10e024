//! The simulated sensor: images of a moving colour pattern **with exact truth**.
//!
//! A [`Scene`] says what the camera sees at rest, a [`Motion`] where every point of it goes. [`Renderer`] draws the
//! frame: every quarter of a pixel is the area-weighted mean of the pattern cells that it covers, then optics blur it,
//! pixels collect it, light scales it, noise falls on it and it is rounded to 8 bits. [`Motion::flow`] is the
//! displacement that a tracker should find, exact by construction.
//!
//! Coordinates are image px: x right, y down, integer = pixel centre. A point at `x` in the reference lies at
//! `x + displacement(x)` in the current image.
//!
//! ```
//! use fingervision_gel::{Light, Motion, Renderer, Scene};
//!
//! let scene = Scene { width: 64, height: 48, ..Scene::default() };
//! let motion = Motion::shift(5.0);
//! let renderer = Renderer::new(&scene)?;
//! let reference = renderer.render(&Motion::STILL, Light::EVEN, 1)?;
//! let current = renderer.render(&motion, Light::EVEN, 2)?;
//! let truth = motion.flow(scene.width, scene.height);
//! # assert_eq!((reference.size(), current.size(), truth.u.size()), ((64, 48), (64, 48), (64, 48)));
//! # Ok::<(), fingervision_gel::GelError>(())
//! ```

mod blur;
mod coverage;
mod error;
mod motion;
mod pattern;
mod render;
mod scene;

pub use error::GelError;
pub use motion::{Motion, TrueFlow};
pub use pattern::{ColourPattern, NEIGHBOUR_DISTANCE};
pub use render::{Light, Renderer};
pub use scene::Scene;

//! The simulated sensor: images of a patterned gel **with exact truth**.
//!
//! There are two simulations. A **scene** is the whole sensor: a [`Scene`] describes the indenter, its motion, and the
//! camera. [`Simulation`] solves the press by finite elements and returns frames with their [`Truth`]; solved presses
//! are kept in a [`PressCache`].
//!
//! ```
//! use fingervision_gel::{PressCache, Scene, Simulation};
//! use std::ops::ControlFlow;
//!
//! let mut scene = Scene::find("board")?;
//! scene.set_all([("render.width", "64"), ("render.height", "48")])?;
//! let mut simulation = Simulation::new(&scene)?;
//! simulation.solve(&PressCache::OFF, &mut |_| ControlFlow::Continue(()))?;
//! let flow = simulation.truth(20)?.flow.at(32, 24);
//! assert_eq!(simulation.frame(20)?.size(), (64, 48));
//! # assert!(flow[0] > 100.0);
//! # Ok::<(), fingervision_gel::SceneError>(())
//! ```
//!
//! A **sheet** is a pattern that is displaced by a formula, without mechanics and without a camera:
//!
//! A [`Sheet`] describes the image at rest, a [`Motion`] the displacement of every point. [`SheetRenderer`] draws the
//! frame: every quarter of a pixel is the area-weighted mean of the pattern cells that it covers; then follow the blur
//! of the optics, the mean over each pixel, the light, the noise and rounding to 8 bits. [`Motion::flow`] is the
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
mod cells;
mod coverage;
mod error;
mod indenter;
mod pattern;
mod polygon;
mod render;
mod scene;
mod sheet;
mod truth;

pub use error::GelError;
pub use fingervision_elastic::{ContactLaw, MeshParams, Resolution};
pub use indenter::{Indenter, IndenterError, IndenterRelief, IndenterShape};
pub use pattern::{
    ColourPattern, Coupling, Motif, NEIGHBOUR_DISTANCE, Paper, Pattern, PatternError, Print, Texture, Trackability,
    View, trackability,
};
pub use render::{FrameRenderer, MotionBlur, RenderError, RenderParams, RingLight};
pub use scene::{
    CacheError, CacheSize, CameraTable, ContactTable, EarlyEnd, Keyframe, MaterialTable, MotionKind, Origin,
    PressCache, Progress, RandomScenes, ReadyMade, Scene, SceneError, SceneMotion, Simulation, SolvedPress,
};
pub use sheet::{Light, Motion, Sheet, SheetRenderer, TrueFlow};
pub use truth::{Truth, TruthProjector};

//! Camera-based touch: from images of a gel with a dense random pattern to displacement, depth, contact and force.
//!
//! A [`Profile`] describes one sensor. A [`Tracker`] made from it takes [`Frame`]s and gives a [`Reading`] for each.
//! Here the frames are those of a simulated press, whose sensor is known; [`open`] reads them from a folder or a video file,
//! and your own program can make them from the images of a camera.
//!
#![cfg_attr(feature = "simulate", doc = "```")]
#![cfg_attr(not(feature = "simulate"), doc = "```ignore")]
//! use fingervision::{Fields, Frame, PressCache, Scene, Simulation, Tracker, simulated_profile};
//! # use std::ops::ControlFlow::Continue;
//!
//! let mut scene = Scene::from_toml("motion = { frames = 7 }\nindenter = { shape = 'sphere', radius_mm = 6.0 }")?;
//! scene.make_draft();
//! let mut press = Simulation::new(&scene)?;
//! let frames = press.solve(&PressCache::OFF, &mut |_| Continue(()))?.states.len();
//! let mut tracker = Tracker::new(&simulated_profile(&scene), press.size(), true, Fields::default())?;
//! for number in 0..frames {
//!     let (sequence, capture_time_s) = (number as u64, number as f64 / 30.0);
//!     let reading = tracker.track(&Frame { sequence, capture_time_s, pixels: press.frame(number)?.clone() })?;
//!     println!("{:?} mm deep, force {:?} N {}", reading.max_depth_mm, reading.force_n, reading.flags);
//! }
//! # let (reading, pressed) = (tracker.reading(), press.states()[frames - 1].force_n[2] as f32);
//! # assert!((reading.max_depth_mm.unwrap() - 2.0).abs() < 0.2, "{:?} mm", reading.max_depth_mm);
//! # assert!((reading.force_n.unwrap()[2] / pressed - 1.0).abs() < 0.2, "{:?} N of {pressed}", reading.force_n);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The crate's `examples/` track a folder into the files that the command writes, feed their own frames, use the flow
//! alone, compare a press with its truth, and calibrate depth.
//!
//! # Conventions
//!
//! Lengths are in mm, forces in N, positions in images in px, `(x, y)` with x right, y down and integers at pixel
//! centres; arrays are `[row][column]`. Depth is positive where the gel is pressed in. All fields of a reading lie on the
//! reference grid: they belong to points of the gel. [`ReadingNumbers::flags`] lists the problems of a frame. [`Reading::valid`] and
//! [`Reading::depth_deviation`] mark the pixels that are not valid.
//!
//! Errors name the wrong quantity and its value; their `hint()`, if there is one, says what to do about it. Enums and structs
//! that may get more members are `#[non_exhaustive]`.
//!
//! # Features
//!
//! - `simulate`, on by default: the simulated sensor ([`Scene`], [`Simulation`], [`SimulatedSource`]), which also lets
//!   [`open`] take `sim:SCENE`. Without it the crate needs no finite elements of a press, no fonts and no meshes.
//! - `video`, on by default: [`open`] reads video files, with a decoder of H.264.
//!
//! # Crates
//!
//! Everything in this crate comes from other crates, which can be used separately: `fingervision-flow` for the flow,
//! `fingervision-gel` for all of the simulation, `fingervision-touch` for the tracker's parts, `fingervision-calibrate`
//! for the fits that write a profile.

// Images and frames.
pub use fingervision_image::{Frame, Image, ImageError, Pixels, Rect};

// Frames in.
#[cfg(not(feature = "simulate"))]
pub use fingervision_source::open;
pub use fingervision_source::{FrameFormat, Options, Source, SourceError};

// From a frame to a reading.
pub use fingervision_touch::{
    DeferredDensity, Fields, Fingerprint, Flag, Flags, HealthCounts, Reading, ReadingNumbers, Team, TrackError,
    Tracker, TractionGrid,
};

// The sensor.
pub use fingervision_elastic::{GelBlock, LayerError};
pub use fingervision_optics::{Camera, CameraError, CameraParams, Distortion};
pub use fingervision_settings::{Place, SettingsError};
pub use fingervision_touch::{
    DensityMethod, DensityParams, DepthLaw, DepthLine, DepthMethod, DepthSection, ElasticMode, ElasticParams,
    GuidedFilterParams, ImageSection, ParameterError, PatternSection, PerspectiveGain, Policy, Profile, ProfileError,
    ProfileReview, ReferenceParams, Remark, Weight,
};

// The flow on its own.
pub use fingervision_flow::{
    AffineParams, Estimate, FlowError, FlowEstimator, FlowField, FlowHistory, FlowParams, Picture, Preset, Reference,
    RefineParams, SearchParams, Start, ValidityParams,
};

// Readings out.
pub use fingervision_plot::flow_colours;
pub use fingervision_sink::{
    Field, Overlay, Precision, Preview, PreviewOptions, RunFolder, RunOptions, RunSummary, Sink, SinkError,
    write_pixels, write_png,
};

#[cfg(feature = "simulate")]
mod simulate {
    pub use fingervision_elastic::{ContactLaw, Law, MeshParams, Pose, Resolution, SurfaceState};
    pub use fingervision_gel::{
        CacheError, CameraTable, ContactTable, EarlyEnd, Indenter, IndenterShape, Keyframe, MaterialTable, MotionKind,
        Origin, Pattern, PressCache, Progress, ReadyMade, RenderParams, Scene, SceneError, SceneMotion, Simulation,
        SolvedPress, Truth,
    };
    pub use fingervision_simulation::{
        SimulatedFrame, SimulatedLocation, SimulatedSource, SimulationFolder, open, simulated_profile,
    };
}

#[cfg(feature = "simulate")]
pub use simulate::*;

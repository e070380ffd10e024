//! The accuracy benchmark: methods for depth against exact truth, over scenes and over variations of the sensor.
//!
//! Every [`Case`] is a ready-made scene under one [`Variation`] of the default sensor. Its images are rendered,
//! tracked, and every [`Method`] makes a depth map of the last frame, whose errors are computed by region
//! ([`DepthScore`]). A method that needs calibration is calibrated as a user would do it, with nine presses on the same
//! sensor, tracked from images, with sticking contact. There is no separate calibration for other friction, because
//! friction is a property of the object, not of the sensor. The elastic inverse needs no calibration press: it takes
//! camera and gel of the scene. Only this method estimates contact and force; their errors are computed as well.
//!
//! The tracker can be given values that differ from the simulated sensor ([`Benchmark::assignments`]): this shows the
//! effect of a wrong profile or of a part that is switched off. Calibration presses are always solved on draft meshes.
//!
//! Other programs can take part with files: see [`Entry`].

mod cases;
mod entry;
mod methods;
mod page;
mod report;
mod run;

pub use crate::experiment::Extent;
pub use cases::{Case, Variation, cases};
pub use entry::Entry;
pub use methods::Method;
pub use report::{BenchmarkReport, CaseReport, MethodMeans, MethodScore};
pub(crate) use run::with_dots;
pub use run::{Benchmark, run};

#[cfg(doc)]
use crate::experiment::DepthScore;

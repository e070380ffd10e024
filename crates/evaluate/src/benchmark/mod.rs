//! The accuracy benchmark: ways to depth against exact truth, over scenes and over what varies between sensors.
//!
//! Every [`Case`] is a ready-made scene under one [`Variation`] of the default sensor. Its images are rendered, tracked, and
//! every [`Method`] makes a depth map of the last frame, which is scored by region ([`DepthScore`]). A method that needs
//! calibration gets what a user would have: the nine calibration presses on the same sensor, tracked from images, held
//! by sticking contact. Friction is the object's and not the sensor's: there is no calibration of its own for it. The
//! elastic inverse needs no press: camera and gel are the scene's own. Only this method estimates contact and force, which are scored too.
//!
//! The tracker can be given values that differ from the simulated sensor ([`Benchmark::assignments`]): what a wrong profile costs, or a part
//! that is switched off. Calibration presses are solved on draft meshes whatever mesh the cases have.
//!
//! Any other program takes part by its files: see [`Entry`].

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

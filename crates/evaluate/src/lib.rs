//! Readings against truth: the accuracy tables of the tracker.
//!
//! Five kinds of test images, each with the required and the measured figure:
//!
//! - [`pairs`]: simulated pairs with exact truth, several patterns each, and whether the predicted deviation holds.
//! - [`recordings`]: recorded pairs and a recorded press. They are not part of the project: they lie in a folder of
//!   their own, and where that is missing there is nothing to measure.
//! - [`sequences`]: simulated presses, frame by frame through the whole tracker under every reference policy.
//! - [`resolution`]: a star with exact truth: which periods of a displacement are resolved, and with how much noise.
//! - [`motion`]: simulated presses at several speeds: the flow in contact, at its rim and elsewhere.
//!
//! Everything is seeded: the same code gives the same tables.
//!
//! And the errors of any run: [`run`] compares a folder of fields with the simulator's truth.
//!
//! [`dots`] follows a sparse grid of dots, the baseline that a dense pattern is compared with.
//!
//! ```no_run
//! let tables = fingervision_evaluate::pairs::measure(3)?;
//! for table in [&tables.accuracy, &tables.calibration] {
//!     println!("{table}");
//! }
//! # Ok::<(), fingervision_evaluate::EvaluateError>(())
//! ```

pub mod benchmark;
pub mod dots;
mod end_point;
mod error;
pub mod experiment;
mod filtered_density;
mod matcher;
pub mod motion;
pub mod page;
pub mod pairs;
pub mod paper;
pub mod recordings;
pub mod resolution;
pub mod run;
pub mod sequences;
mod table;

pub use end_point::{Calibration, end_point_errors, mean, quantile, without_border};
pub use error::EvaluateError;
pub use table::{Asked, Row, Table};

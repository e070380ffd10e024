//! Compares readings with the truth, and makes the accuracy tables of the tracker.
//!
//! Six kinds of test images, each with the required and the measured figure:
//!
//! - [`pairs`]: simulated pairs with exact truth, several patterns each, and a check of the predicted deviation.
//! - [`recordings`]: recorded pairs and presses, in a folder that is not part of the project. If it is
//!   missing, they are not measured.
//! - [`sequences`]: simulated presses, frame by frame through the whole tracker under every reference policy.
//! - [`resolution`]: a star pattern with exact truth, which shows the smallest period of a displacement that is
//!   resolved, and the noise.
//! - [`motion`]: simulated presses at several speeds: errors of the flow in contact, at its rim and elsewhere.
//! - [`elasticity`]: simulated presses, stuck and sliding: errors of depth, contact and force.
//!
//! Everything is seeded: the same code gives the same tables.
//!
//! In addition, [`run`] compares the fields of any run with the simulator's truth.
//!
//! [`dots`] tracks a sparse grid of dots, the baseline for the dense pattern.
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
pub mod elasticity;
mod end_point;
mod error;
pub mod experiment;
mod filtered_density;
mod matcher;
pub mod motion;
pub mod page;
pub mod pairs;
pub mod paper;
mod press_options;
pub mod recordings;
pub mod resolution;
pub mod run;
pub mod sequences;
mod table;

pub use end_point::{Calibration, end_point_errors, mean, quantile, without_border};
pub use error::EvaluateError;
pub use press_options::PressOptions;
pub use table::{Asked, Row, Table};

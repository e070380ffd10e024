//! Fits the law between density feature and depth to presses of known depth.
//!
//! [Du2021] presses squares into the gel at its centre, midway and at a corner, takes the largest density feature of
//! every frame, and fits one line to all. A [`PressRecorder`] makes such a curve from a press. A [`DepthFit`] fits the
//! published line, a line through the origin and the law of perspective to all of them. It reports the error of each on
//! presses that were not used for the fit, and whether one line fits all presses. Depth is fitted as a function of the
//! feature, because it is used in this direction, although the depths are the exact values.
//!
//! [Du2021]: https://doi.org/10.1109/LRA.2021.3061306

mod curve;
mod error;
mod fit;
mod law_check;
mod limits;
mod maximum;
mod order;
mod picture;
mod regression;
mod report;
mod table;
mod thresholds;

pub use curve::{Place, PressCurve, PressPoint, PressRecorder};
pub(crate) use curve::{check_camera, tracking};
pub use error::DepthFitError;
pub use fit::{DepthFit, FittedLaw, Method, PressFit};
pub(crate) use limits::check_depths;
pub use maximum::{Maximum, MaximumFinder};
pub(crate) use order::{LEAST_CORRELATION, disorder};
pub use regression::{LineFit, OriginFit, fit_line, fit_through_origin};
pub use table::PressFolder;

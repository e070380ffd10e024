//! Fits the camera to a patterned board that slides in known steps.

mod board;
mod corner_error;
mod corner_file;
mod corners;
mod error;
mod fit;
mod model;
mod observability;
mod picture;
mod prior;
mod problem;
mod report;
mod residuals;
mod slide;
mod steps;
mod text;
mod thresholds;
mod unknowns;

pub use board::{BoardFlow, BoardTracker, GRID, Node};
pub use corner_error::CornerError;
pub use corner_file::read_corners;
pub use corners::{Corner, CornerFit, fit_corners};
pub use error::{BoardError, LEAST_IMAGES};
pub use fit::{CameraFit, FitOptions, ResidualTable, Start, fit_camera};
pub use model::{BoardFlowJacobian, board_flow, board_flow_with_jacobian};
pub use observability::{BlindDirection, Estimate, Knowledge};
pub use prior::{Prior, Priors};
pub use report::{CameraReport, SlideReport};
pub use residuals::{ResidualMap, Residuals};
pub use slide::Slide;
pub(crate) use steps::median;
pub use unknowns::{UNKNOWNS, Unknown, Unknowns, camera_params, unknowns_of};

//! Simulated presses tracked from their images, in memory: the basis of the benchmark and of the paper's figures.
//!
//! A [`Recording`] is a scene's images with the truth of its last frame. [`follow`] finds the displacement in them by
//! the dense pattern or by dots, and the density feature of every frame. [`calibrate`] fits depth laws to the nine
//! calibration presses, and [`Scorer`] gives the errors of a depth map.

mod calibration;
mod depth;
mod elastic;
mod error;
mod extent;
mod following;
mod recording;
mod score;

pub use calibration::{CALIBRATION, calibrate};
pub use depth::{clipped, depth_of};
pub(crate) use elastic::force_errors;
pub use elastic::{ElasticRun, ElasticScore};
pub use error::ExperimentError;
pub use extent::Extent;
pub use following::{Followed, Following, follow, follow_last};
pub use recording::Recording;
pub(crate) use recording::profile_with_assignments;
pub use score::{DepthScore, Scorer};

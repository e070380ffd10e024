//! Simulated presses tracked from their images, in memory: what the benchmark and the paper's figures are made of.
//!
//! A [`Recording`] is a scene's images with the truth of its last frame. [`follow`] finds the displacement in them by the
//! dense pattern or by dots, and the density feature of every frame. [`calibrate`] makes depth laws of the nine
//! calibration presses, and [`Scorer`] says how far a depth map is from the truth.

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
pub use elastic::ElasticScore;
pub use error::ExperimentError;
pub use extent::Extent;
pub use following::{Followed, Following, follow, follow_last};
pub use recording::Recording;
pub use score::{DepthScore, Scorer};

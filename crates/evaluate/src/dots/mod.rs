//! A sparse grid of dots, followed: the baseline that a dense pattern is compared with.
//!
//! Done as well as the dots allow. Every dot's centre is the centroid of the light that it takes away, background
//! subtracted: a twentieth of a pixel. From frame to frame each is found where its last motion leads, and only where the
//! choice is mutual; a dot that is lost takes its neighbours' motion until it is found again. Between the dots the
//! displacement is the thin-plate spline through all that are seen: the smoothest field that passes through scattered
//! points ([Bookstein1989]), which a missing dot does not break as it would a product of splines on the grid.
//!
//! [`DotTracker`] gives the flow, [`DotSensor`] the density feature from it, by the same estimator and filter that a dense
//! flow goes through; depth follows by the same laws.
//!
//! [Bookstein1989]: https://doi.org/10.1109/34.24792

mod detect;
mod error;
mod follow;
mod sensor;
mod spline;
#[cfg(test)]
mod tests;
mod tracker;

pub use detect::find_dots;
pub use error::DotError;
pub use sensor::{DotSensor, DotTouch};
pub use tracker::{DotReading, DotTracker};

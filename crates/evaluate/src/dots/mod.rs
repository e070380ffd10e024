//! Tracks a sparse grid of dots, the baseline for the dense pattern.
//!
//! The centre of a dot is the centroid of its pixels, each weighted by how much darker it is than the background. It is
//! accurate to a twentieth of a pixel. Each dot is searched where its last motion predicts it, and assigned only if the
//! two are each other's nearest; a lost dot takes the motion of its neighbours until it is found again. Between the
//! dots the displacement is the thin-plate spline through all visible dots ([Bookstein1989]). It does not need a
//! regular grid, so dots may be missing.
//!
//! [`DotTracker`] gives the flow, [`DotSensor`] the density feature from it, with the same estimator and filter as for
//! a dense flow; depth follows by the same laws.
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

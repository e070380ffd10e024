//! The numbers that the paper prints.

/// Correlation of the largest feature with depth: the lower bound for each of the nine presses, and the value for all
/// together.
pub(super) const EACH_CORRELATION: f64 = 0.98;
pub(super) const POOLED_CORRELATION: f64 = 0.95;
/// Table I: mean and standard deviation of the residual before, after, and on the test set. The unit is not printed.
pub(super) const RESIDUAL_MEAN: [f64; 3] = [4.57e-3, 2.23e-3, 2.16e-3];
pub(super) const RESIDUAL_DEVIATION: [f64; 3] = [4.37e-3, 1.34e-3, 1.27e-3];
/// Frames per second, with a GTX 1060.
pub(super) const FRAMES_PER_SECOND: f64 = 40.0;
/// Smallest distance between the colours of neighbouring cells in RGB.
pub(super) const COLOUR_DISTANCE: f64 = 30.0;

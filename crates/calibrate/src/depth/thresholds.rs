//! The limits on presses for the depth law, and on the law, all in one place.
//!
//! Correlations, factors and parts of the largest depth do not depend on the size of a sensor. The only lengths are
//! limits that no sensor exceeds.

/// See [`THRESHOLDS`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Thresholds {
    /// Largest difference of a press's first depth from zero, as a part of its largest depth: the accuracy with which
    /// zero is set by hand.
    pub(super) most_depth_at_rest: f64,
    /// Largest possible depth, mm: no gel of a touch sensor is thicker. Depths in µm exceed it.
    pub(super) deepest_mm: f64,
    /// Least value of the largest depth of a press, mm: a shallower press moves the pattern by less than the noise.
    /// Depths in m are below it.
    pub(super) shallowest_mm: f64,

    /// Least number of frames for the test of their order: with fewer, a correlation means little.
    pub(super) least_counted: usize,
    /// Least correlation of motion and depth in a press, dimensionless. It is near 1 for images in order and near 0 or
    /// negative for images in another order.
    pub(super) least_correlation: f64,

    /// For `Maximum::Robust`, the limit on the predicted deviation of a pixel is at least this, px, even if that of the
    /// profile is smaller. Under a deep sliding face most pixels exceed the usual limit, though most errors are a third
    /// of the prediction. A median tolerates these errors, but not the missing pixels.
    pub(super) median_deviation_px: f32,

    /// A press with a smaller correlation of feature and depth is named in a warning, dimensionless. The presses of
    /// `docs/calibrate.md` have 0.80 or more.
    pub(super) usual_correlation: f64,
    /// A lower correlation, of a press or of all together, is named in a warning, dimensionless. The paper's nine presses
    /// have more than 0.98 each and 0.95 together; simulated sensors are below 0.95 where a rim near the border is lost.
    pub(super) good_correlation: f64,
    /// Largest ratio of two presses' slopes without a warning: with a larger ratio, a common line is wrong by 20 % or
    /// more for one of them.
    pub(super) most_factor: f64,
    /// Largest difference, without a warning, by which the pooled correlation is below the least one of a single press:
    /// with more, the presses do not have a common line.
    pub(super) most_drop: f64,

    /// Largest error on presses that were left out, over the largest depth. A law without any information has 0.6: the
    /// root mean square of evenly spaced depths.
    pub(super) most_error: f64,
    /// Possible gains relative to perspective alone: ten times wider in both directions than the 0.5 to 2 of simulated
    /// sensors.
    pub(super) gains: [f64; 2],
    /// Possible slopes without a camera, mm. By perspective alone a slope is half the distance to the camera, so they
    /// belong to distances of 0.2 to 2000 mm.
    pub(super) slopes_mm: [f64; 2],
}

/// The values in use. Limits without a stated measurement are choices. The tests of this crate check them with presses
/// of simulated sensors.
pub(super) const THRESHOLDS: Thresholds = Thresholds {
    most_depth_at_rest: 0.02,
    deepest_mm: 50.0,
    shallowest_mm: 0.02,
    least_counted: 4,
    least_correlation: 0.7,
    median_deviation_px: 2.0,
    usual_correlation: 0.6,
    good_correlation: 0.95,
    most_factor: 1.5,
    most_drop: 0.05,
    most_error: 0.5,
    gains: [0.05, 20.0],
    slopes_mm: [0.1, 1000.0],
};

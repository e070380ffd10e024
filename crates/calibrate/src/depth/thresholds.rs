//! The limits on presses for the depth law, and on the law, all in one place.
//!
//! Correlations, factors and parts of the deepest depth are free of scale. Lengths are only those that no sensor has.

/// See [`THRESHOLDS`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Thresholds {
    /// The first depth of a press may differ from zero by this part of its largest: the accuracy of a hand-set zero.
    pub(super) most_depth_at_rest: f64,
    /// No gel is pressed deeper, mm.
    pub(super) deepest_mm: f64,
    /// A shallower press moves the pattern by less than noise, mm.
    pub(super) shallowest_mm: f64,

    /// Fewer frames show no order of the images.
    pub(super) least_counted: usize,
    /// Correlation of motion and depth that a press has at least, dimensionless.
    pub(super) least_correlation: f64,

    /// Largest predicted deviation of a pixel that is used for `Maximum::Robust`, px, if the profile is stricter. Under a
    /// deep sliding face most pixels exceed the usual limit, though most errors are a third of the prediction; a median
    /// tolerates these, but not the holes that they would leave.
    pub(super) median_deviation_px: f32,

    /// Presses whose feature follows their depth less than this are named in a warning, dimensionless.
    pub(super) usual_correlation: f64,
    /// A lower correlation, of a press or of all together, is named in a warning, dimensionless. The paper's nine presses
    /// have more than 0.98 each and 0.95 together; simulated sensors fall below 0.95 where a rim near the border is lost.
    pub(super) good_correlation: f64,
    /// Slopes that differ by more than this factor do not belong to a common line.
    pub(super) most_factor: f64,
    /// A pooled correlation that is lower by this than the least one of a single press does not belong to a common line
    /// either.
    pub(super) most_drop: f64,

    /// Error on presses that were left out over the deepest depth. A law without any information has 0.6.
    pub(super) most_error: f64,
    /// Gains over that of perspective alone: simulated sensors have 0.5 to 2.
    pub(super) gains: [f64; 2],
    /// Slopes allowed without a camera, mm: half the distance to the camera by perspective alone.
    pub(super) slopes_mm: [f64; 2],
}

/// The values in use. One without a source is a choice; the tests of this crate hold it against presses of simulated sensors.
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

//! The thresholds of depth from elasticity, all in one place.
//!
//! None of them is a length in mm. They are pixels of flow, multiples of the flow's own deviation, or parts of the gel's
//! thickness, of the largest depth or of the contact. A sensor that is scaled as a whole (gel, distance and pattern) gives the
//! same images, so it gives the same depth divided by the scale, and the same flags.

/// See [`THRESHOLDS`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Thresholds {
    /// The gel is at rest while no cell of it seems to move by more than this, px: twice the largest motion that image noise
    /// of 5 grey levels causes in any cell.
    pub(super) still_px: f64,
    /// The same over the flow's deviation, for images noisier than that: the ratio on the images of the simulated sensor,
    /// whose deviation is 0.023 px.
    pub(super) still_over_deviation: f64,
    /// Error of the flow against which a stuck face is judged, px, where the flow's deviation does not ask for more.
    pub(super) noise_px: f64,
    /// The same over the flow's deviation: the ratio on the images of the simulated sensor.
    pub(super) noise_over_deviation: f64,
    /// Deviation of the flow in the images the network was trained on, px. The network's own error covers it.
    pub(super) training_deviation_px: f64,
    /// A flow whose deviation is this many times that of the training images is flagged as uncertain.
    pub(super) most_over_training: f64,

    /// A stuck face: least part of its inner cells that move with it.
    pub(super) least_matching: f64,
    /// A stuck face: largest median distance of its cells from the common motion, over the flow's error. Presses that stick
    /// have 0.25 to 0.5, gel that slides evenly 1.3 and more.
    pub(super) most_residual: f64,
    /// A stuck face: largest deviation of its depth, in thicknesses. Above it the rays are too parallel to measure depth.
    pub(super) most_face_deviation: f64,
    /// A stuck face: largest difference from the network's depth, as a part of that. Gel that slides and spreads evenly
    /// under a face grows in the image as if it came closer.
    pub(super) most_change: f64,
    /// Least deviation of a stuck face's depth, in thicknesses: the error of its rim and of the gel's model.
    pub(super) face_deviation: f64,
    /// Without the network: a face that is less deep than this cannot be distinguished from gel at rest, in thicknesses.
    pub(super) least_face_depth: f64,
    /// Without the network: depth up to which a cell counts for more the deeper it is, in thicknesses.
    pub(super) counted_face_depth: f64,
    /// Without the network: deviation of the depth of free gel, in thicknesses, and as a part of that depth.
    pub(super) free_deviation: [f64; 2],
    /// Deviation of depth while the gel is at rest, in thicknesses: mean depth that a ball of 0.6 thicknesses radius reaches
    /// before the gel is seen to move.
    pub(super) rest_deviation: f64,

    /// Part of contact in which the flow has to be valid.
    pub(super) least_tracked: f64,
    /// Depth beyond which the strain is too large for linear elasticity, in thicknesses.
    pub(super) linear_range: f64,
    /// Distance from contact, in thicknesses, from which on motion is compared with elasticity: nearer, the strain is too large
    /// for a linear law.
    pub(super) away: f64,
    /// Deviations of the flow that explain a difference between motion and elasticity.
    pub(super) flow_deviations: f64,
    /// Motion away from contact, root mean square, px, below which it does not show whether the gel fits.
    pub(super) least_motion_px: f64,
    /// Motion away from contact that may remain unexplained, root mean square, as a part of the largest depth.
    pub(super) most_unexplained: f64,
}

/// The values in use. Where no source is given they were measured on presses of the simulated sensor.
pub(super) const THRESHOLDS: Thresholds = Thresholds {
    still_px: 0.06,
    still_over_deviation: 2.6,
    noise_px: 0.04,
    noise_over_deviation: 1.7,
    training_deviation_px: 0.025,
    most_over_training: 1.8,
    least_matching: 0.6,
    most_residual: 0.8,
    most_face_deviation: 0.005,
    most_change: 0.25,
    face_deviation: 0.002,
    least_face_depth: 0.01,
    counted_face_depth: 0.1,
    free_deviation: [0.001, 0.1],
    rest_deviation: 0.005,
    least_tracked: 0.1,
    linear_range: 0.25,
    away: 0.25,
    flow_deviations: 2.0,
    least_motion_px: 0.25,
    most_unexplained: 0.05,
};

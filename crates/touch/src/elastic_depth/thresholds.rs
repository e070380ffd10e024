//! The thresholds of depth from elasticity in one place; only the models of a face's strain, of a stuck shape
//! and of the force have their own ([`super::frozen_strain`], [`super::stuck_shape`], [`super::stiffening`], [`super::far_field`]).
//!
//! None of them is a length in mm. They are pixels of flow, multiples of the flow's deviation, or relative to the gel's
//! thickness, to the largest depth or to the size of contact. If a sensor is scaled as a whole (gel, distance and
//! pattern), its images do not change. It then gives the same depth relative to its size, and the same flags.

/// See [`THRESHOLDS`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Thresholds {
    /// The gel counts as at rest while no cell moves by more than this, px: twice the largest apparent motion that
    /// image noise of 5 grey levels causes in any cell.
    pub(super) still_px: f64,
    /// The same limit relative to the flow's deviation, used for noisier images: the ratio on the images of the
    /// simulated sensor, whose deviation is 0.023 px.
    pub(super) still_over_deviation: f64,
    /// Least error of the flow that is assumed in the search for a stuck face, px.
    pub(super) noise_px: f64,
    /// The same error relative to the flow's deviation, used if it is larger: the ratio on the images of the simulated
    /// sensor.
    pub(super) noise_over_deviation: f64,
    /// Deviation of the flow in the images the network was trained on, px. The error that the network estimates
    /// includes its effect.
    pub(super) training_deviation_px: f64,
    /// A flow is flagged as uncertain if its deviation is more than this many times that of the training images.
    pub(super) most_over_training: f64,

    /// A stuck face: least part of its inner cells that move with it.
    pub(super) least_matching: f64,
    /// A stuck face: largest median distance of its cells from the common motion, over the flow's error. Measured: 0.25
    /// to 0.5 for presses that stick, 1.3 and more for gel that slides evenly.
    pub(super) most_residual: f64,
    /// A stuck face: largest deviation of its depth, in thicknesses. Above it the rays are too parallel to measure
    /// depth.
    pub(super) most_face_deviation: f64,
    /// A stuck face: largest difference from the network's depth, relative to that depth. It rejects gel that slides
    /// and spreads evenly under a face, which grows in the image as if it came closer.
    pub(super) most_change: f64,
    /// Least deviation of a stuck face's depth, in thicknesses, caused by the errors of its rim and of the gel's model.
    pub(super) face_deviation: f64,
    /// Without the network: a face that is less deep than this cannot be distinguished from gel at rest, in
    /// thicknesses.
    pub(super) least_face_depth: f64,
    /// Without the network: the weight of a cell in the search for a face is its depth up to this limit, in
    /// thicknesses.
    pub(super) counted_face_depth: f64,
    /// Without the network: deviation of the depth outside contact, as a constant in thicknesses and relative to that
    /// depth.
    pub(super) free_deviation: [f64; 2],
    /// Deviation of depth while the gel is at rest, in thicknesses: the mean depth under a ball with a radius of 0.6
    /// thicknesses just before its motion is detected.
    pub(super) rest_deviation: f64,

    /// Least part of contact with valid flow; below it the reading is flagged.
    pub(super) least_tracked: f64,
    /// Largest distance of a place in contact from the nearest one with valid flow, px of the undeformed surface; beyond it the
    /// reading is flagged. In simulated presses it is at most 16 px, beside walls.
    pub(super) hole_px: f64,
    /// Depth beyond which the strain is too large for linear elasticity, in thicknesses.
    pub(super) linear_range: f64,
    /// Motion of contact along the surface relative to its depth, root mean squares, beyond which shear cannot be subtracted
    /// accurately: if contact is not known to stick, and if it is, because then depth does not depend on it.
    pub(super) most_drag: [f64; 2],
    /// The same motion up to which contact counts as pressed straight down: its shape is then known. It is below 0.02 for
    /// faces that stick, and at the side of the image an error of the depth of 10 % makes it 0.05.
    pub(super) least_drag: f64,
    /// Least distance from contact, in thicknesses, at which motion is compared with elasticity: nearer to contact, the
    /// strain is too large for a linear law.
    pub(super) away: f64,
    /// A difference between motion and elasticity of up to this many deviations of the flow is attributed to the flow.
    pub(super) flow_deviations: f64,
    /// Least motion away from contact, root mean square, px, for the test whether the gel fits: smaller motion is
    /// dominated by the error of the flow.
    pub(super) least_motion_px: f64,
    /// Largest difference between motion away from contact and elasticity, root mean square, relative to the largest
    /// depth plus a part of the motion along the surface.
    pub(super) most_unexplained: f64,
    /// That part: the difference grows with shear, too, but less.
    pub(super) shear_over_depth: f64,
}

/// The values in use. Those without a stated source were measured on presses of the simulated sensor.
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
    hole_px: 24.0,
    linear_range: 0.25,
    most_drag: [0.5, 2.0],
    least_drag: 0.1,
    away: 0.25,
    flow_deviations: 2.0,
    least_motion_px: 0.25,
    most_unexplained: 0.05,
    shear_over_depth: 0.3,
};

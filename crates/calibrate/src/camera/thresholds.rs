//! The limits on recordings of the board, and on the camera that is fitted to them, all in one place.
//!
//! The camera is fitted to flow in px, so the limits are in px of flow, or they are parts and factors. The only lengths
//! are limits that no sensor exceeds.

/// See [`THRESHOLDS`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Thresholds {
    /// Least part of an image with texture: with less, the flow is not known in enough of the image to separate tilt,
    /// distortion and distance.
    pub(super) least_textured: f32,
    /// Least part of the texture that is found in the next image. The images of a good recording share four fifths of
    /// the board or more, because a step is at most a fifth of the image; with less than this limit they do not show
    /// the same board.
    pub(super) least_matched: f32,
    /// Least part of the grid's nodes with a mean flow, for the same reason as `least_textured`.
    pub(super) least_seen: f64,
    /// A node needs valid flow in at least this part of the pairs: otherwise its mean would be that of a short part of
    /// the slide.
    pub(super) least_pairs: f64,
    /// Samples farther from a node's median than this many robust deviations are left out, if they are also farther
    /// than `outlier_px`. With normal noise that is one sample of 16 000.
    pub(super) outlier_deviations: f64,
    /// Samples nearer to a node's median than this, px, are never left out: ten times the usual error of the flow.
    pub(super) outlier_px: f64,

    /// With less flow than this, px, the board counts as at rest: thirty times the usual error of the flow.
    pub(super) least_flow_px: f64,
    /// Largest difference of a step from the usual one, as a part of it. A repeated or skipped image differs by 1; the
    /// steps of a stage with a screw differ by far less than this limit.
    pub(super) step_tolerance: f64,
    /// Largest difference between the directions of the slide and of the flow, degrees: more than a camera or board
    /// that is mounted a little askew, less than the 90° between x and y.
    pub(super) direction_tolerance_deg: f64,
    /// Largest ratio, in both directions, between the flow and the flow predicted by a known camera: more than the
    /// error of a measured distance, less than that of a wrong step, such as 0.5 mm instead of 1 mm.
    pub(super) scale_tolerance: f64,

    /// A fit whose residual is more than this part of a step's flow has not found the camera. In a good recording the
    /// residual is about 0.005 px, of a step of 3 to 30 px.
    pub(super) most_unexplained: f64,

    /// A camera with a larger residual for a step's flow, px, is not the one that took the images: a hundred times the
    /// residual of a good recording.
    pub(super) most_residual_px: f64,
    /// Possible distances from a lens to a gel, mm.
    pub(super) distances_mm: [f64; 2],
    /// Possible focal lengths over the image's width: a fisheye lens has less than the minimum, a telephoto lens more
    /// than the maximum.
    pub(super) focal_lengths: [f64; 2],

    /// Largest uncertainty of focal length and distance, as a part of them: twice that of the distance of a profile's own
    /// camera. Beyond it the slides and priors have not determined the camera.
    pub(super) most_uncertain: f64,
    /// A larger uncertainty, as a part, is remarked: a distance measured with a ruler is known to 2 %.
    pub(super) remarked_uncertainty: f64,

    /// Largest difference between focal length or distance and its prior, in the prior's standard deviations, that is not
    /// remarked.
    pub(super) contradiction: f64,

    /// Largest mean residual of corners, px: detectors of corners are accurate to a fraction of a pixel, so a larger
    /// residual comes from wrong board positions or poses.
    pub(super) most_corner_residual_px: f64,

    /// Part of the prior's variance that the slides must remove. Below it the value is reported as that of the prior.
    pub(super) determined: f64,
}

/// The values in use. Limits without a stated measurement are choices. The tests of this crate check that good
/// simulated recordings of the board pass them and that recordings with a fault do not.
pub(super) const THRESHOLDS: Thresholds = Thresholds {
    least_textured: 0.2,
    least_matched: 0.3,
    least_seen: 0.3,
    least_pairs: 0.5,
    outlier_deviations: 4.0,
    outlier_px: 0.1,
    least_flow_px: 0.3,
    step_tolerance: 0.1,
    direction_tolerance_deg: 30.0,
    scale_tolerance: 1.25,
    most_unexplained: 0.05,
    most_residual_px: 0.5,
    distances_mm: [1.0, 2000.0],
    focal_lengths: [0.15, 20.0],
    most_uncertain: 0.2,
    remarked_uncertainty: 0.05,
    contradiction: 3.0,
    most_corner_residual_px: 2.0,
    determined: 0.5,
};

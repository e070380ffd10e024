//! The limits on recordings of the board, and on the camera that is fitted to them, all in one place.
//!
//! They are px of flow, which the camera measures in, or parts and factors. Lengths are only those that no sensor has.

/// See [`THRESHOLDS`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Thresholds {
    /// Texture must cover this part of an image.
    pub(super) least_textured: f32,
    /// This part of the texture must be found again.
    pub(super) least_matched: f32,
    /// This part of the grid must be tracked.
    pub(super) least_seen: f64,
    /// A node's flow is a mean over this part of the pairs at least.
    pub(super) least_pairs: f64,
    /// Samples farther from a node's median than this many robust deviations are left out, if they are farther than `outlier_px`.
    pub(super) outlier_deviations: f64,
    /// Samples nearer to a node's median than this, px, are never left out.
    pub(super) outlier_px: f64,

    /// Below this the board is at rest, px.
    pub(super) least_flow_px: f64,
    /// A step that differs from the usual one by more than this part is a fault.
    pub(super) step_tolerance: f64,
    /// Allowed deviation of the direction, degrees.
    pub(super) direction_tolerance_deg: f64,
    /// Allowed deviation from a known camera, as a factor.
    pub(super) scale_tolerance: f64,

    /// A camera that leaves more than this part of the flow unexplained is rejected.
    pub(super) most_unexplained: f64,

    /// A camera with a residual above this for a step's flow, px, is not the one that took the images: a good recording has a
    /// hundredth.
    pub(super) most_residual_px: f64,
    /// Distances from a lens to a gel, mm.
    pub(super) distances_mm: [f64; 2],
    /// Focal lengths over the image's width: a fisheye lens has less, a telephoto lens more.
    pub(super) focal_lengths: [f64; 2],

    /// A camera that misses the corners by more than this on average is rejected, px.
    pub(super) most_corner_residual_px: f64,

    /// Below this the slides removed so little of the prior's variance that the value is that of the prior.
    pub(super) determined: f64,
}

/// The values in use. One without a source is a choice; the tests of this crate hold it against simulated recordings of the board.
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
    most_corner_residual_px: 2.0,
    determined: 0.5,
};

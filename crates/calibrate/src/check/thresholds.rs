//! The limits on what a recording may look like, all in one place.
//!
//! What depends on the image is in px of flow or a part of the image; what depends on the light is a part of a level. Grey
//! levels are absolute where the camera's noise is: it does not change with the light.

/// See [`THRESHOLDS`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Thresholds {
    /// At most this part of an image's values may be at either end of their range. A pattern whose colours fill the whole
    /// range has half of it there.
    pub(super) most_clipped: f64,
    /// Range of the mean grey level in which a pattern is exposed well. A camera's noise does not shrink with the light, so
    /// below the minimum the pattern has less than half of the possible contrast over noise.
    pub(super) mean_levels: [f64; 2],

    /// If the flow's deviation exceeds this over half of the image, px, the texture is too weak: a tenth of the least motion
    /// that a calibration uses.
    pub(super) most_deviation_px: f64,

    /// Still images: this part of the first one has texture.
    pub(super) least_textured: f32,
    /// Still images: this part of the first one's texture is found again.
    pub(super) least_matched: f32,
    /// Still images: allowed motion of the whole image, px: with more, a calibration to a hundredth of a pixel is impossible.
    pub(super) most_drift_px: f64,
    /// Still images: allowed motion of all but `moving_part` of the image against the rest, px: several deviations of the least
    /// accurate flow that passes.
    pub(super) most_motion_px: f64,
    /// Part of an image that may move by more than the motion that is allowed for the rest.
    pub(super) moving_part: f64,
    /// Still images: allowed relative change of the mean level: well above noise, well below what the flow tolerates.
    pub(super) most_flicker: f64,
    /// No camera has less noise than this, grey levels.
    pub(super) least_noise_levels: f64,

    /// A press's first image: if less than this part of the pattern is found, it is another pattern.
    pub(super) least_matched_at_rest: f32,
    /// A press's first image: allowed motion of the whole image since the gel was recorded untouched, px.
    pub(super) most_shift_px: f64,
    /// A press's first image: allowed motion of all but `moving_part` of the image, px.
    pub(super) most_motion_at_rest_px: f64,

    /// A step below this, px, is smaller than the unevenness of a hand-driven stage.
    pub(super) least_step_px: f64,
    /// A step above this part of the image's smaller side leaves too little of the board in both images.
    pub(super) most_step: f64,

    /// A press whose largest motion is below this, px, contains little information about depth.
    pub(super) least_motion_px: f64,
    /// If more than this part of the images is lost, the curve has gaps.
    pub(super) most_lost: f64,
    /// The border is this part of the image's smaller side.
    pub(super) border: f64,
    /// A press whose motion at the border is this part of its largest does not end within the image.
    pub(super) most_at_border: f64,
}

/// The values in use. One without a source is a choice; the tests of this crate hold it against simulated recordings with and
/// without the fault.
pub(super) const THRESHOLDS: Thresholds = Thresholds {
    most_clipped: 0.01,
    mean_levels: [40.0, 215.0],
    most_deviation_px: 0.05,
    least_textured: 0.2,
    least_matched: 0.5,
    most_drift_px: 0.02,
    most_motion_px: 0.25,
    moving_part: 0.02,
    most_flicker: 0.03,
    least_noise_levels: 0.01,
    least_matched_at_rest: 0.5,
    most_shift_px: 2.0,
    most_motion_at_rest_px: 0.5,
    least_step_px: 0.5,
    most_step: 0.2,
    least_motion_px: 0.5,
    most_lost: 0.1,
    border: 0.05,
    most_at_border: 0.9,
};

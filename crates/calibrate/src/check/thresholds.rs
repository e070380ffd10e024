//! The limits for the recordings of a calibration, all in one place.
//!
//! Limits on the image are in px of flow or parts of the image, limits on the light are relative to the mean level.
//! Only the noise of the camera, which does not change with the light, is compared in absolute grey levels.

/// See [`THRESHOLDS`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Thresholds {
    /// Largest part of an image's values at the bottom, and at the top, of their range: clipped values have no gradient
    /// to track. For comparison: of a pattern whose colours fill the whole range, half of the values are there.
    pub(super) most_clipped: f64,
    /// Range of the mean grey level of a well exposed pattern. A camera's noise does not shrink with the light: below
    /// the minimum, the ratio of contrast to noise is less than half of the possible one. Above the maximum, bright
    /// cells are close to saturation.
    pub(super) mean_levels: [f64; 2],

    /// Largest median deviation of the flow, px; above it the texture is too weak. It is a tenth of the smallest motion
    /// that a calibration uses.
    pub(super) most_deviation_px: f64,

    /// Still images: the first one needs texture in at least this part for the test of `least_matched`. With less,
    /// `most_deviation_px` reports the image.
    pub(super) least_textured: f32,
    /// Still images: least part of the first one's texture that is found. An image of the same gel matches nearly
    /// completely.
    pub(super) least_matched: f32,
    /// Still images: largest motion of the whole image, px. With more, a calibration to a hundredth of a pixel is
    /// impossible.
    pub(super) most_drift_px: f64,
    /// Still images: largest motion of all but `moving_part` of the image against the rest, px: five times
    /// `most_deviation_px`, so that noise alone does not exceed it.
    pub(super) most_motion_px: f64,
    /// Part of an image whose motion is ignored, so that single wrong samples have no effect.
    pub(super) moving_part: f64,
    /// Still images: largest relative change of the mean level: far above the noise of the mean, far below the change
    /// that the flow tolerates.
    pub(super) most_flicker: f64,
    /// Least noise, grey levels. No camera has less; images with less are copies of one image.
    pub(super) least_noise_levels: f64,

    /// First image of a press: least part of the pattern that is found in the image of the untouched gel; with less, it
    /// shows another pattern.
    pub(super) least_matched_at_rest: f32,
    /// First image of a press: largest shift of the whole image against the image of the untouched gel, px. A larger
    /// shift means that camera or gel has moved in its mount.
    pub(super) most_shift_px: f64,
    /// First image of a press: largest motion of all but `moving_part` of the image, px. It equals `least_motion_px`,
    /// the motion from which a press can be measured.
    pub(super) most_motion_at_rest_px: f64,

    /// Least step of the board, px: a shorter one is smaller than the unevenness of a stage that is moved by hand.
    pub(super) least_step_px: f64,
    /// Largest step of the board, as a part of the image's smaller side: a longer one leaves too little of the board in
    /// both images.
    pub(super) most_step: f64,

    /// Least value of the largest motion in a press, px: ten times `most_deviation_px`; a smaller motion contains
    /// little information about depth.
    pub(super) least_motion_px: f64,
    /// Largest part of a press's images that may be lost: with more, the curve has gaps.
    pub(super) most_lost: f64,
    /// Width of the border, as a part of the image's smaller side.
    pub(super) border: f64,
    /// A press whose motion at the border is this part of its largest motion or more extends beyond the image.
    pub(super) most_at_border: f64,
}

/// The values in use. Limits without a stated measurement are choices. The tests of this crate check them with
/// simulated recordings with and without the fault.
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

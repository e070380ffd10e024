//! The thresholds of the checks of a stream, all in one place: px of flow, parts of the image, factors relative to the
//! reference, and times in s. None depends on the size of the sensor.

/// See [`THRESHOLDS`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Thresholds {
    /// An image is saturated if its part of saturated pixels exceeds that of the reference by more than the first
    /// value, or exceeds the second value.
    pub(super) more_saturated: f32,
    pub(super) most_saturated: f32,
    /// An image is dark if its mean and its contrast are both below these parts of the reference's.
    pub(super) dark_mean: f32,
    pub(super) dark_contrast: f32,
    /// A first image is dark if its mean is below this many grey levels and its contrast below this many times the
    /// camera's noise.
    pub(super) black_levels: f32,
    pub(super) black_contrast: f32,
    /// The gel is at rest if its flow differs from that of the untouched gel by less than this, px (root mean square).
    pub(super) rest_px: f32,
    /// The flow of the untouched gel is replaced only if the current flow differs from it by less than this, px. It is
    /// less than `rest_px`, so that the previous flow, with noise, still counts as rest.
    pub(super) slow_px: f32,
    /// How long the gel must be at rest for that, s.
    pub(super) slow_s: f64,
    /// An image has moved as a whole if at least the first part of it is valid, and a shift, a rotation and a magnification leave at
    /// most the second part of its flow (root mean square).
    pub(super) least_seen: f32,
    pub(super) most_bent: f64,
    /// The flow of the untouched gel is a motion of the whole image, too, if such a motion leaves less than this of it, px: the error of the flow.
    pub(super) even_px: f64,
    /// Flow of the untouched gel above which the reference has drifted, px (root mean square).
    pub(super) drift_px: f32,
    /// The reference has aged if the residual of the untouched gel grows by more than this factor.
    pub(super) aged: f32,
    /// A residual up to this, grey levels, is that of the reference itself: rounding to 8 bits alone leaves more.
    pub(super) repeated_levels: f32,
    /// Number of frames at rest without a valid flow after which a cell counts as damaged.
    pub(super) damaged_frames: u16,
    /// Least number of damaged cells for a report, and least part of the image, damaged or hidden by dirt: gaps in a sparse pattern,
    /// and edges of parts of the housing, are smaller.
    pub(super) least_damaged: usize,
    pub(super) least_damaged_part: f32,
    /// If a larger part of the cells than this is never valid, the pattern is too sparse, not damaged.
    pub(super) most_damaged: f32,
    /// Frames are searched for dirt if their mean level differs from the reference's by less than this, relative to it.
    pub(super) same_light: f32,
    /// Least motion of the gel around a cell for a comparison with the reference, px.
    pub(super) moves_px: f32,
    /// Least difference of this motion from that of the comparisons before, px.
    pub(super) further_px: f32,
    /// Places around a cell move in the same way if their motion differs by less than this from the mean, relative to it.
    pub(super) similar_motion: f32,
    /// Least number of the eight places around a cell that move in the same way.
    pub(super) similar_places: usize,
    /// A cell is suspicious if its flow is smaller than this, relative to the motion around it.
    pub(super) still_motion: f32,
    /// The largest flow of a suspicious cell, px.
    pub(super) still_px: f32,
    /// Largest difference of the motion in a cell from that around it, relative to that.
    pub(super) near_motion: f32,
    /// The same, px.
    pub(super) near_px: f32,
    /// Two levels are the same if they differ by less than this many times the camera's noise.
    pub(super) same_noise: f32,
    /// A pixel has changed if its level differs from the reference by more than this many times that difference.
    pub(super) changed_levels: f32,
    /// A pixel shows gel from elsewhere only if its level there differs by less than this many times that difference.
    pub(super) elsewhere_levels: f32,
    /// Least number of pixels of a cell that stand still in two comparisons.
    pub(super) still_twice: usize,
    /// Least number that stand still in one comparison, if the flow is valid and the motion is at least `clear_px`.
    pub(super) still_once: usize,
    /// Least motion around a cell for a decision after one comparison, px.
    pub(super) clear_px: f32,
    /// An image is torn if at least so many of its first or last rows are equal to those of an earlier frame, and the flow beside
    /// them differs from that frame's by more than so much, px, in at least so many samples; in as many samples within these rows the flow
    /// is valid.
    pub(super) least_torn_rows: usize,
    pub(super) torn_px: f32,
    pub(super) least_torn_samples: usize,
}

/// The values in use.
///
/// - Light: simulated presses change the part of saturated pixels by 0, recorded presses by up to 0.04 (a sensor of
///   which a fifth is saturated); contrast and mean by less than 15 %.
/// - Rest: untouched gel is measured with 0.02 px or better, in simulated and recorded images; after a press an
///   air-filled membrane is off by 0.05 px for seconds. A drift of up to 0.05 px/s is followed; a faster change counts
///   as a touch.
/// - Ageing: the flow eliminates an even change of light, which therefore does not change the residual. In recordings
///   at rest the residual varies by a factor of up to 1.25.
/// - Dirt: in 102 simulated presses without dirt at most one cell of an image is taken for dirty, and in recorded ones those at the
///   edge of a part of the housing. Gel that moves away from a point, a wall or a stroke has other motions on its sides; gel may rest
///   in a narrow ring beside contact, where few pixels stand still twice. Difference of levels: three times that of two images of the
///   same thing.
/// - Tears: the flow of gel at rest differs by less than 0.1 px from frame to frame, also in videos. Beside the blocks that a video does
///   not store again, single samples move by more.
pub(super) const THRESHOLDS: Thresholds = Thresholds {
    more_saturated: 0.05,
    most_saturated: 0.33,
    dark_mean: 0.5,
    dark_contrast: 0.3,
    black_levels: 30.0,
    black_contrast: 2.0,
    rest_px: 0.15,
    slow_px: 0.1,
    slow_s: 2.0,
    least_seen: 0.25,
    most_bent: 0.3,
    even_px: 0.01,
    drift_px: 0.25,
    aged: 1.6,
    repeated_levels: 0.05,
    damaged_frames: 30,
    least_damaged: 2,
    least_damaged_part: 0.005,
    most_damaged: 0.25,
    same_light: 0.15,
    moves_px: 0.6,
    further_px: 0.3,
    similar_motion: 0.5,
    similar_places: 6,
    still_motion: 0.4,
    still_px: 0.6,
    near_motion: 0.25,
    near_px: 0.3,
    same_noise: 4.2,
    changed_levels: 3.0,
    elsewhere_levels: 1.5,
    still_twice: 7,
    still_once: 9,
    clear_px: 1.2,
    least_torn_rows: 32,
    torn_px: 0.1,
    least_torn_samples: 4,
};

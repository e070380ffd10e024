//! The thresholds of reference handling, all in one place: pixels of flow, factors relative to a value measured in the
//! same frame, and numbers of frames. None depends on the size of the sensor.

/// See [`THRESHOLDS`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Thresholds {
    /// Flow that counts as motion, px: well above noise and slow drift.
    pub(super) motion_px: f32,
    /// Least number of moving samples for a decision.
    pub(super) least_moving: usize,
    /// Least part of the moving samples' motion that points towards or away from the centre of perspective.
    pub(super) certain: f32,
    /// Least mean motion far from contact, px: the mean of this many samples is accurate to a few thousandths.
    pub(super) least_far_px: f32,
    /// Least mean motion far from contact as a part of the largest motion: in simulated presses a mean of the wrong
    /// sign is less than half of this.
    pub(super) least_far: f32,
    /// Samples that move by this part of the largest motion belong to the face.
    pub(super) face: f32,
    /// Distance of a face from the centre of perspective, as a part of the image's half height, below which it does not
    /// show a shift.
    pub(super) least_aside: f32,
    /// Least cosine between the face's shift and the line to the centre of perspective.
    pub(super) least_aligned: f32,
    /// Allowed ratio of the face's shift to the shift predicted from its magnification and its distance from the
    /// centre, which is 1 if perspective is the only cause.
    pub(super) shift_by_scale: [f32; 2],
    /// Root mean square residual of the face's motion after shift and magnification, as a part of the largest motion.
    pub(super) most_unexplained: f32,
    /// Change between two frames below which the gel is still, px.
    pub(super) still_px: f32,
    /// Consecutive frames that elasticity explains as a press before the gel of the first image is taken to be at rest.
    pub(super) explained_frames: u64,
    /// Part of the image that may be lost before the whole frame is searched.
    pub(super) most_lost: f32,
    /// Part of the textured patches that must match before a frame becomes a keyframe.
    pub(super) keyframe_matched: f32,
    /// Least number of frames between two keyframes.
    pub(super) keyframe_interval: u64,
}

/// The values in use, measured on presses of the simulated sensor.
pub(super) const THRESHOLDS: Thresholds = Thresholds {
    motion_px: 0.5,
    least_moving: 16,
    certain: 0.5,
    least_far_px: 0.04,
    least_far: 0.02,
    face: 0.6,
    least_aside: 0.2,
    least_aligned: 0.9,
    shift_by_scale: [0.5, 1.5],
    most_unexplained: 0.2,
    still_px: 0.05,
    explained_frames: 5,
    most_lost: 0.05,
    keyframe_matched: 0.9,
    keyframe_interval: 10,
};

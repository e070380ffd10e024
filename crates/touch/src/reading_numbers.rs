//! The numbers of a reading, without its fields.

use crate::Flags;

/// Every number of a reading that belongs to the whole frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct ReadingNumbers {
    /// The frame's number in its source.
    pub sequence: u64,
    /// When the frame was exposed, s, on the source's clock.
    pub capture_time_s: f64,
    /// Frames that the source dropped since tracking began.
    pub dropped_frames: u64,
    /// Number of the reference that the frame was matched with, from 0.
    pub reference_id: u64,
    /// Number of references that were kept when the frame was matched.
    pub reference_count: usize,
    /// Photometric error, grey levels: under the stack policy the largest error of the coarse check that decides about
    /// references, otherwise the root mean square of the matching patches' residuals.
    pub photometric_error: f32,
    /// Time from the frame's arrival to the reading, ms. It is the only value that differs from run to run.
    pub latency_ms: f64,
    /// The problems of the reading.
    pub flags: Flags,
    /// Part of the image in which the flow is never valid while that of the gel around it is, or which dirt on the optics hides,
    /// 0 to 1; see [`Flag::GelDamaged`](crate::Flag).
    pub damaged_part: f32,
    /// Mean grey level of the region of interest, 0 to 255.
    pub mean_level: f32,
    /// Part of its pixels of which a channel is saturated, 0 to 1.
    pub saturated_part: f32,
    /// Its sharpness, dimensionless, as [`Picture::sharpness`](fingervision_flow::Picture::sharpness): compare it only with
    /// other images of this sensor.
    pub sharpness: f32,
    /// Largest depth where it is valid, mm.
    pub max_depth_mm: Option<f32>,
    /// Area of contact in the undeformed surface, mm²; with elastic depth.
    pub contact_area_mm2: Option<f32>,
    /// Force on the gel `(x, y, z)`, N; with elastic depth and a known Young's modulus.
    pub force_n: Option<[f32; 3]>,
    /// Torque on the gel about the z axis through the centre of contact, N mm; where there is a force.
    pub torque_nmm: Option<f32>,
}

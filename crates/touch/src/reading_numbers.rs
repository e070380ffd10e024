//! The numbers of a reading, without its fields.

use crate::{Flags, Reading};

/// What a table has of a reading: every number that belongs to the whole frame.
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
    /// As [`Reading::photometric_error`], grey levels.
    pub photometric_error: f32,
    /// Time from the frame's arrival to the reading, ms.
    pub latency_ms: f64,
    /// The problems of the reading.
    pub flags: Flags,
    /// As [`Reading::damaged_part`], 0 to 1.
    pub damaged_part: f32,
    /// Largest depth where it is valid, mm.
    pub max_depth_mm: Option<f32>,
    /// Area of contact in the undeformed surface, mm².
    pub contact_area_mm2: Option<f32>,
    /// Force on the gel `(x, y, z)`, N.
    pub force_n: Option<[f32; 3]>,
    /// Torque on the gel about the z axis through the centre of contact, N mm.
    pub torque_nmm: Option<f32>,
}

impl Reading {
    /// The numbers of this reading.
    #[must_use]
    pub fn numbers(&self) -> ReadingNumbers {
        ReadingNumbers {
            sequence: self.sequence,
            capture_time_s: self.capture_time_s,
            dropped_frames: self.dropped_frames,
            reference_id: self.reference_id,
            reference_count: self.reference_count,
            photometric_error: self.photometric_error,
            latency_ms: self.latency_ms,
            flags: self.flags,
            damaged_part: self.damaged_part,
            max_depth_mm: self.max_depth_mm,
            contact_area_mm2: self.contact_area_mm2,
            force_n: self.force_n,
            torque_nmm: self.torque_nmm,
        }
    }

    /// Takes over everything but the fields.
    pub(crate) fn take_numbers(&mut self, numbers: &ReadingNumbers) {
        self.sequence = numbers.sequence;
        self.capture_time_s = numbers.capture_time_s;
        self.dropped_frames = numbers.dropped_frames;
        self.reference_id = numbers.reference_id;
        self.reference_count = numbers.reference_count;
        self.photometric_error = numbers.photometric_error;
        self.latency_ms = numbers.latency_ms;
        self.flags = numbers.flags;
        self.damaged_part = numbers.damaged_part;
        self.max_depth_mm = numbers.max_depth_mm;
        self.contact_area_mm2 = numbers.contact_area_mm2;
        self.force_n = numbers.force_n;
        self.torque_nmm = numbers.torque_nmm;
    }
}

//! What subscribers get.

use std::sync::Arc;
use std::time::Duration;

use fingervision_source::{EncodedFrame, FrameTruth};
use fingervision_touch::{Reading, ReadingNumbers};

/// Something that a sensor did. Times are those of [`host_time_s`](crate::host_time_s).
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Message {
    /// A frame was captured. It may still be dropped before it is tracked.
    Frame {
        /// The sensor's index.
        sensor: usize,
        /// The frame as it came.
        frame: Arc<EncodedFrame>,
        /// When it was captured.
        captured_s: f64,
    },
    /// The truth of the frame before, if it is simulated; for those who get frames.
    Truth {
        /// The sensor's index.
        sensor: usize,
        /// The frame's number.
        sequence: u64,
        /// The frame's time on the source's own clock.
        capture_time_s: f64,
        /// When the frame was captured.
        captured_s: f64,
        /// The truth.
        truth: FrameTruth,
    },
    /// A frame was tracked.
    Reading {
        /// The sensor's index.
        sensor: usize,
        /// The numbers of the reading.
        numbers: ReadingNumbers,
        /// When the frame was captured.
        captured_s: f64,
        /// When the reading was ready.
        ready_s: f64,
    },
    /// The whole reading, after its [`Message::Reading`]; at the rate that the subscriber asked for.
    Fields {
        /// The sensor's index.
        sensor: usize,
        /// The reading and its frame.
        snapshot: Arc<Snapshot>,
    },
    /// Something that a user should know, as a sentence: a damaged frame, an unplugged camera, a new reference.
    Event {
        /// The sensor's index.
        sensor: usize,
        /// When it happened.
        host_time_s: f64,
        /// The sentence, without a full stop.
        text: String,
    },
    /// The sensor has ended; nothing more comes from it.
    End {
        /// The sensor's index.
        sensor: usize,
    },
}

/// A complete copy of one reading.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Snapshot {
    /// The reading.
    pub reading: Reading,
    /// The frame that it was computed from.
    pub frame: Arc<EncodedFrame>,
    /// When the frame was captured, s of [`host_time_s`](crate::host_time_s).
    pub captured_s: f64,
    /// When the reading was ready, s of [`host_time_s`](crate::host_time_s).
    pub ready_s: f64,
}

/// What a subscriber wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Interest {
    /// The captured frames.
    pub frames: bool,
    /// Whole readings, at most one of each sensor in this time; zero: all of them. `None`: only their numbers.
    pub fields_every: Option<Duration>,
    /// Messages that may wait; the oldest goes if one more comes.
    pub capacity: usize,
}

impl Interest {
    /// The numbers of every reading.
    #[must_use]
    pub fn readings() -> Self {
        Self { frames: false, fields_every: None, capacity: 256 }
    }
}

//! The messages to subscribers.

use std::sync::Arc;
use std::time::Duration;

use fingervision_source::{EncodedFrame, FrameTruth};
use fingervision_touch::{Reading, ReadingNumbers, StageTimes};

/// A message from a sensor. Times are those of [`host_time_s`](crate::host_time_s).
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Message {
    /// A frame was captured. It may still be dropped before it is tracked.
    Frame {
        /// The sensor's index.
        sensor: usize,
        /// The frame as the camera or the source delivered it.
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
        /// Where the time in between went.
        times: FrameTimes,
    },
    /// The whole reading, after its [`Message::Reading`]; at the rate that the subscriber requested.
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
    /// The sensor has ended; this is its last message.
    End {
        /// The sensor's index.
        sensor: usize,
    },
}

/// Where the time from a frame's capture to its reading went.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameTimes {
    /// From capture until a thread had time for it, ms.
    pub waiting_ms: f64,
    /// Decoding, ms.
    pub decode_ms: f64,
    /// Tracking.
    pub stages: StageTimes,
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

/// The messages that a subscriber requests.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Interest {
    /// The captured frames.
    pub frames: bool,
    /// The shortest time between two whole readings of a sensor; zero: every reading. `None`: only the numbers of
    /// readings.
    pub fields_every: Option<Duration>,
    /// Capacity of the queue; if it is full, the oldest message is dropped.
    pub capacity: usize,
}

impl Interest {
    /// The numbers of every reading.
    #[must_use]
    pub fn readings() -> Self {
        Self { frames: false, fields_every: None, capacity: 256 }
    }
}

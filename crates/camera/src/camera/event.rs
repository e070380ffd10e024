//! What a camera returns: frames, events and counts.

use std::fmt;

use fingervision_image::Frame;

/// A frame or an event.
#[derive(Debug, Clone, PartialEq)]
pub enum Captured {
    /// A frame. A gap in the numbers means that frames are missing.
    Frame(Frame),
    /// Something that a user should know.
    Event(Event),
}

/// The result of [`Camera::next_encoded`](crate::Camera::next_encoded).
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Arrived {
    /// A frame, which is not decoded.
    Frame,
    /// Something that a user should know.
    Event(Event),
}

/// Something that happened to a camera.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Event {
    /// A frame could not be decoded; it is left out.
    Damaged {
        /// Its number.
        sequence: u64,
        /// What is wrong with it.
        reason: String,
    },
    /// The camera is missing; it is opened again when it is back.
    Unplugged,
    /// The driver reports an error; the camera is started again.
    Failed {
        /// The system's message.
        reason: String,
    },
    /// The camera captures again. The gap before the number of the next frame is the number of frames that are missing.
    Restarted,
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Damaged { sequence, reason } => write!(f, "frame {sequence} is left out: {reason}"),
            Self::Unplugged => f.write_str("the camera is unplugged; capture goes on when it is back"),
            Self::Failed { reason } => write!(f, "the camera is started again: {reason}"),
            Self::Restarted => f.write_str("the camera captures again"),
        }
    }
}

/// Counts of received and missing frames.
///
/// The number of the last frame is `frames + damaged + dropped − 1`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Frames that were returned.
    pub frames: u64,
    /// Frames that are missing: the driver had no free buffer, or the camera was unplugged.
    pub dropped: u64,
    /// Frames that the driver delivered twice; the second one was left out.
    pub duplicates: u64,
    /// Frames that could not be decoded.
    pub damaged: u64,
    /// How often the camera was opened again.
    pub restarts: u64,
    /// How often the driver's clock was set back. Times then continue from that of the previous frame.
    pub clock_steps: u64,
}

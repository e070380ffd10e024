//! What a camera hands out.

use std::fmt;

use fingervision_image::Frame;

/// A frame, or what happened instead.
#[derive(Debug, Clone, PartialEq)]
pub enum Captured {
    /// A frame. A gap in the numbers means that frames are missing.
    Frame(Frame),
    /// Something that a user should know.
    Event(Event),
}

/// What [`Camera::next_encoded`](crate::Camera::next_encoded) brings.
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
    /// The camera is gone; it is looked for.
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

/// How many frames came, and how many did not.
///
/// The number of the last frame is `frames + damaged + dropped − 1`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Frames that were handed out.
    pub frames: u64,
    /// Frames that are missing: the driver had no room for them, or the camera was away.
    pub dropped: u64,
    /// Frames that the driver delivered again; they were not handed out.
    pub duplicates: u64,
    /// Frames that could not be decoded.
    pub damaged: u64,
    /// How often the camera was opened again.
    pub restarts: u64,
    /// How often the driver's clock was set back. Time goes on from the frame before.
    pub clock_steps: u64,
}

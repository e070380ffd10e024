//! Why sensors cannot start.

use fingervision_camera::CameraError;
use fingervision_source::SourceError;
use fingervision_touch::TrackError;

/// Why a sensor cannot start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PipelineError {
    /// The camera cannot be used.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// The source cannot be read.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The profile does not fit the frames.
    #[error(transparent)]
    Track(#[from] TrackError),
    /// No frame arrived that can be decoded.
    #[error("{sensor}: no usable frame: {reason}")]
    NoFrame {
        /// The sensor's name.
        sensor: String,
        /// The reason.
        reason: String,
    },
    /// A thread cannot be started.
    #[error("a thread for {sensor} cannot be started: {error}")]
    Thread {
        /// The sensor's name.
        sensor: String,
        /// The system's message.
        error: std::io::Error,
    },
}

impl PipelineError {
    /// What the user can do about it, if anything.
    #[must_use]
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::Camera(error) => Some(error.hint()),
            Self::Source(error) => error.hint(),
            Self::Track(error) => error.hint(),
            Self::NoFrame { .. } => {
                Some("unplug the camera and plug it in again; `fingervision doctor` shows what it offers".into())
            }
            Self::Thread { .. } => Some("close other programs, or raise the limit of `ulimit -u`".into()),
        }
    }
}

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
    /// No frame came that can be decoded.
    #[error("{sensor}: no usable frame: {reason}")]
    NoFrame {
        /// The sensor's name.
        sensor: String,
        /// What came instead.
        reason: String,
    },
    /// The system gives no thread.
    #[error("a thread for {sensor} cannot be started: {error}")]
    Thread {
        /// The sensor's name.
        sensor: String,
        /// The system's message.
        error: std::io::Error,
    },
}

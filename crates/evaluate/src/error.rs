use fingervision_flow::FlowError;
use fingervision_gel::GelError;
use fingervision_image::ImageError;
use fingervision_touch::TrackError;
use std::path::{Path, PathBuf};

/// Why a table cannot be measured.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EvaluateError {
    /// A sheet cannot be rendered.
    #[error(transparent)]
    Gel(#[from] GelError),
    /// The flow cannot be computed with these parameters.
    #[error(transparent)]
    Flow(#[from] FlowError),
    /// A frame does not have the expected size.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A frame cannot be tracked.
    #[error(transparent)]
    Track(#[from] TrackError),
    /// A recorded file cannot be used.
    #[error("{}: {reason}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
}

impl EvaluateError {
    pub(crate) fn file(file: &Path, reason: impl Into<String>) -> Self {
        Self::File { file: file.to_owned(), reason: reason.into() }
    }
}

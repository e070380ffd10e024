//! Errors of readers of video files, before the file and the frame are known.

use crate::SourceError;
use std::io;
use std::path::Path;

/// Why a container cannot be read.
#[derive(Debug)]
pub(crate) enum Fault {
    /// The system refuses.
    Io(io::Error),
    /// The file contradicts its own format.
    Damaged(&'static str),
    /// The file is fine, but its content is not read; a noun.
    NotRead(String),
}

impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl Fault {
    /// The error for the file at `path`.
    pub(crate) fn at(self, path: &Path) -> SourceError {
        match self {
            Self::Io(error) => SourceError::io(path, error),
            Self::Damaged(reason) => SourceError::Container { path: path.to_owned(), reason: reason.into() },
            Self::NotRead(what) => SourceError::unread_video(path, what),
        }
    }
}

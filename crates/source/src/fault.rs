//! Errors of readers and decoders, before the file and the frame are known.

use crate::SourceError;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
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

/// Runs foreign decoding code; a panic in there becomes an error.
///
/// The H.264 decoder is new and gets files from anywhere. Some damaged files make it panic, and a panic must not
/// end a robot's process. After a panic the decoder is in an unknown state and must not be used again: a source that
/// continues after an error does so with a new decoder.
pub(crate) fn guarded<T>(decode: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(decode)).map_err(|_| "damaged so much that the decoder fails".into())
}

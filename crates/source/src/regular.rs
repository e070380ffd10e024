//! Only regular files are opened: a pipe or a device can block forever.

use crate::SourceError;
use std::fs;
use std::path::Path;

/// Refuses anything except a regular file or a link to one. A missing file is reported by the caller that opens it.
pub(crate) fn check(path: &Path) -> Result<(), SourceError> {
    match fs::metadata(path) {
        Ok(metadata) if !metadata.is_file() => Err(SourceError::no_regular_file(path)),
        _ => Ok(()),
    }
}

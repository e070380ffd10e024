//! Regular files alone are opened: a pipe or a device can keep whoever opens it waiting without end.

use crate::SourceError;
use std::fs;
use std::path::Path;

/// Refuses what is neither a regular file nor a link to one. What is not there at all is left to whoever opens it.
pub(crate) fn check(path: &Path) -> Result<(), SourceError> {
    match fs::metadata(path) {
        Ok(metadata) if !metadata.is_file() => Err(SourceError::no_regular_file(path)),
        _ => Ok(()),
    }
}

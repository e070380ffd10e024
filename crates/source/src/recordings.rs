//! The recordings in a folder.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

use crate::folder::images_in;
use crate::natural::natural_order;
use crate::{SourceError, is_video};

/// The subfolder for the images of a press, where other files lie beside them.
const FRAMES: &str = "frames";

/// The recordings in a folder, in natural order: folders of images, videos, and files for which `is_recording` holds. Of a
/// folder whose images are in its subfolder `frames`, that subfolder. Hidden files and all others are ignored.
///
/// None if the folder itself contains images, or has such a subfolder: then it is a recording.
///
/// # Errors
///
/// [`SourceError::NotFound`] and [`SourceError::Io`] if a folder cannot be read.
pub fn recordings_in(
    folder: impl AsRef<Path>,
    is_recording: impl Fn(&Path) -> bool,
) -> Result<Vec<PathBuf>, SourceError> {
    let folder = folder.as_ref();
    if images_of(folder)?.is_some() {
        return Ok(Vec::new());
    }
    let io = |error| SourceError::io(folder, error);
    let mut entries = Vec::new();
    for entry in fs::read_dir(folder).map_err(io)? {
        let path = entry.map_err(io)?.path();
        let name = path.file_name().map(OsStr::to_string_lossy).unwrap_or_default().into_owned();
        if !name.starts_with('.') {
            entries.push((name, path));
        }
    }
    entries.sort_by(|(a, _), (b, _)| natural_order(a, b));
    let mut recordings = Vec::new();
    for (_, path) in entries {
        if path.is_dir() {
            recordings.extend(images_of(&path)?);
        } else if is_recording(&path) || is_video(&path) {
            recordings.push(path);
        }
    }
    Ok(recordings)
}

/// The folder itself or its subfolder `frames`, whichever contains images.
fn images_of(folder: &Path) -> Result<Option<PathBuf>, SourceError> {
    for folder in [folder.to_owned(), folder.join(FRAMES)] {
        if folder.is_dir() && !images_in(&folder)?.is_empty() {
            return Ok(Some(folder));
        }
    }
    Ok(None)
}

//! The recordings in a folder.

use std::path::{Path, PathBuf};

use crate::SourceError;
use crate::folder::{entries_of, images_in};

/// The subfolder for the images of a press, where other files lie beside them.
const FRAMES: &str = "frames";
/// The file that only the results of tracking contain.
const RUN: &str = "run.toml";
/// Files with these endings are recordings, also those that cannot be read.
const ENDINGS: [&str; 7] = ["mcap", "mp4", "m4v", "mov", "avi", "mkv", "webm"];
/// The least number of images of a recording: a single one is a picture of something.
const LEAST_IMAGES: usize = 2;

/// The folder with the images of a recording: its subfolder `frames`, if there is one, or the folder itself.
#[must_use]
pub fn images_of(recording: &Path) -> PathBuf {
    let frames = recording.join(FRAMES);
    if frames.is_dir() { frames } else { recording.into() }
}

/// The recordings in a folder, in natural order: folders with two images or more, or those in their subfolder `frames`, and files
/// with the ending of a video or of a recording. Hidden files, results of tracking and all others are left out, and folders in
/// these folders are not searched.
///
/// Empty if the folder is a recording itself.
///
/// # Errors
///
/// [`SourceError::NotFound`] and [`SourceError::Io`] if the folder cannot be read. What it contains may be unreadable.
pub fn recordings_in(folder: impl AsRef<Path>) -> Result<Vec<PathBuf>, SourceError> {
    let folder = folder.as_ref();
    if shows_gel(folder)? {
        return Ok(Vec::new());
    }
    let paths = entries_of(folder)?.into_iter().map(|(_, path)| path);
    Ok(paths.filter_map(|path| if path.is_dir() { folder_of_images(&path) } else { file(path) }).collect())
}

/// Whether a folder contains the images of a recording.
fn shows_gel(folder: &Path) -> Result<bool, SourceError> {
    let is_run = folder.join(RUN).is_file();
    Ok(!is_run && images_in(&images_of(folder))?.len() >= LEAST_IMAGES)
}

/// The images of a folder, if it is a recording. One that cannot be read counts as one: its error is that of its images.
fn folder_of_images(folder: &Path) -> Option<PathBuf> {
    shows_gel(folder).unwrap_or(true).then(|| images_of(folder))
}

/// A file, if its ending is that of a recording.
fn file(path: PathBuf) -> Option<PathBuf> {
    let ending = path.extension()?.to_str()?.to_ascii_lowercase();
    ENDINGS.contains(&ending.as_str()).then_some(path)
}

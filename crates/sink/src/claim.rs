//! A folder of our own: made, found empty, or emptied of what an earlier command wrote there.

use std::fs;
use std::io::{ErrorKind, Write as _};
use std::path::Path;

use crate::SinkError;

/// What a command writes into a folder.
#[derive(Debug)]
pub(crate) struct FolderKind {
    /// What the folder is then called.
    pub(crate) noun: &'static str,
    /// The file that tells such a folder from any other. It is removed last: a clearing that is cut short still leaves a
    /// folder of this kind.
    pub(crate) marker: &'static str,
    /// What else it may hold, a path each.
    pub(crate) files: &'static [&'static str],
    /// A folder in it that holds nothing but numbered images, if there is one.
    pub(crate) images: Option<&'static str>,
}

impl FolderKind {
    /// Makes the folder and sees that it is empty, or empties it of what an earlier command wrote.
    ///
    /// # Errors
    ///
    /// [`SinkError::Previous`] if it holds an earlier one and `overwrite` is not asked for, [`SinkError::FolderNotEmpty`]
    /// if it holds anything else, [`SinkError::Write`] if it cannot be made or emptied.
    pub(crate) fn claim(&self, path: &Path, overwrite: bool) -> Result<(), SinkError> {
        fs::create_dir_all(path).map_err(SinkError::writing(path))?;
        let is_empty = fs::read_dir(path).map_err(SinkError::writing(path))?.next().is_none();
        let is_ours = path.join(self.marker).exists();
        match (is_empty, is_ours) {
            (true, _) => Ok(()),
            (false, false) => Err(SinkError::FolderNotEmpty { path: path.to_path_buf(), noun: self.noun }),
            (false, true) if overwrite => self.empty(path),
            (false, true) => Err(SinkError::Previous { path: path.to_path_buf(), noun: self.noun }),
        }
    }

    fn empty(&self, path: &Path) -> Result<(), SinkError> {
        if let Some(images) = self.images.map(|images| path.join(images)).filter(|images| images.is_dir()) {
            for entry in fs::read_dir(&images).map_err(SinkError::writing(&images))? {
                let image = entry.map_err(SinkError::writing(&images))?.path();
                if is_numbered(&image) {
                    remove(&image)?;
                }
            }
        }
        self.files.iter().chain([&self.marker]).try_for_each(|name| remove(&path.join(name)))
    }
}

fn is_numbered(image: &Path) -> bool {
    let stem = image.file_stem().unwrap_or_default().to_string_lossy();
    image.extension().is_some_and(|extension| extension == "png")
        && stem.len() >= 6
        && stem.bytes().all(|byte| byte.is_ascii_digit())
}

fn remove(path: &Path) -> Result<(), SinkError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(SinkError::Write { path: path.to_path_buf(), error }),
        _ => Ok(()),
    }
}

/// Writes a whole small file onto the disk.
pub(crate) fn write_file(path: &Path, bytes: &[u8]) -> Result<(), SinkError> {
    let write = || {
        let mut file = fs::File::create(path)?;
        file.write_all(bytes)?;
        file.sync_all()
    };
    write().map_err(SinkError::writing(path))
}

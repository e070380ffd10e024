//! An output folder: created, found empty, or cleared of the files of an earlier command, and locked meanwhile.

use std::fs::{self, File, TryLockError};
use std::io::ErrorKind;
use std::path::Path;

use crate::SinkError;

/// The kind of output that a command writes into a folder.
#[derive(Debug)]
pub struct FolderKind {
    /// The noun for such a folder.
    pub noun: &'static str,
    /// The file that identifies such a folder. It is removed last: after an interrupted clearing the folder is still
    /// recognised.
    pub marker: &'static str,
    /// Other files it may contain, as paths.
    pub files: &'static [&'static str],
    /// A folder in it that contains only numbered images, if there is one.
    pub images: Option<&'static str>,
    /// Folders in it that are removed if nothing is left in them.
    pub folders: &'static [&'static str],
}

/// Keeps other commands from writing into a folder while it exists. The system releases it when a process is killed.
#[derive(Debug)]
pub struct FolderLock {
    /// Absent if the file system has no locks.
    _folder: Option<File>,
}

impl FolderLock {
    /// Locks an existing folder.
    fn take(path: &Path) -> Result<Self, SinkError> {
        // Not every file system has locks: without them, writing goes ahead.
        let Ok(folder) = File::open(path) else { return Ok(Self { _folder: None }) };
        match folder.try_lock() {
            Err(TryLockError::WouldBlock) => Err(SinkError::Busy { path: path.to_path_buf() }),
            Err(TryLockError::Error(_)) => Ok(Self { _folder: None }),
            Ok(()) => Ok(Self { _folder: Some(folder) }),
        }
    }
}

impl FolderKind {
    /// Refuses what [`claim`](Self::claim) would refuse because of the folder's content; changes nothing.
    ///
    /// # Errors
    ///
    /// [`SinkError::Previous`], [`SinkError::FolderNotEmpty`] or, if there is a file of this name, [`SinkError::Write`].
    pub fn check(&self, path: &Path, overwrite: bool) -> Result<(), SinkError> {
        let mut entries = match fs::read_dir(path) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
            entries => entries.map_err(SinkError::writing(path))?,
        };
        match (entries.next().is_none(), path.join(self.marker).exists()) {
            (false, false) => Err(SinkError::FolderNotEmpty { path: path.to_path_buf(), noun: self.noun }),
            (false, true) if !overwrite => Err(SinkError::Previous { path: path.to_path_buf(), noun: self.noun }),
            _ => Ok(()),
        }
    }

    /// Creates the folder, locks it and makes sure that it is empty, or clears it of the files of an earlier command.
    ///
    /// # Errors
    ///
    /// [`SinkError::Busy`] if another command is writing there, [`SinkError::Previous`] if it holds an earlier one and
    /// `overwrite` is not asked for, [`SinkError::FolderNotEmpty`] if it holds anything else, [`SinkError::Write`] if
    /// it cannot be made or emptied.
    pub fn claim(&self, path: &Path, overwrite: bool) -> Result<FolderLock, SinkError> {
        fs::create_dir_all(path).map_err(SinkError::writing(path))?;
        let lock = FolderLock::take(path)?;
        self.check(path, overwrite)?;
        // An empty folder has none of these files.
        self.empty(path)?;
        Ok(lock)
    }

    /// Removes the files of an earlier command, the marker last.
    pub(crate) fn empty(&self, path: &Path) -> Result<(), SinkError> {
        if let Some(images) = self.images.map(|images| path.join(images)).filter(|images| images.is_dir()) {
            for entry in fs::read_dir(&images).map_err(SinkError::writing(&images))? {
                let image = entry.map_err(SinkError::writing(&images))?.path();
                if is_numbered(&image) {
                    remove(&image)?;
                }
            }
        }
        self.files.iter().try_for_each(|name| remove(&path.join(name)))?;
        for folder in self.folders.iter().copied().chain(self.images) {
            // A folder that contains other files is kept.
            let _ = fs::remove_dir(path.join(folder));
        }
        remove(&path.join(self.marker))
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

//! A file that is replaced only when its new version is complete. If the command ends before, nothing is left of the new
//! one.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The files that are not finished.
static ALL: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// A file that is being written beside the one that it replaces. It is removed if this is dropped, or if a signal ends
/// the command.
#[derive(Debug)]
pub(crate) struct Unfinished {
    path: PathBuf,
}

impl Unfinished {
    /// Begins with a copy of `whole`, if that exists. What a killed command has left at `path` is removed.
    pub(crate) fn copy_of(whole: &Path, path: PathBuf) -> io::Result<Self> {
        all().push(path.clone());
        let begun = Self { path };
        match fs::remove_file(&begun.path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        if whole.exists() {
            fs::copy(whole, &begun.path)?;
        }
        Ok(begun)
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Replaces the file of this name.
    pub(crate) fn finish(self, whole: &Path) -> io::Result<()> {
        fs::rename(&self.path, whole)
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
        all().retain(|path| *path != self.path);
    }
}

fn all() -> MutexGuard<'static, Vec<PathBuf>> {
    ALL.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all unfinished files, because the command ends.
pub(crate) fn remove_all() {
    for path in all().drain(..) {
        let _ = fs::remove_file(path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_finished_file_replaces_the_whole_one_and_an_unfinished_one_disappears() {
        let folder = tempfile::tempdir().unwrap();
        let [whole, draft] = ["profile", "draft"].map(|name| folder.path().join(name));
        fs::write(&draft, "left by a killed command").unwrap();
        let begun = Unfinished::copy_of(&whole, draft.clone()).unwrap();
        assert!(!draft.exists());
        fs::write(begun.path(), "new").unwrap();
        begun.finish(&whole).unwrap();
        assert_eq!(fs::read_to_string(&whole).unwrap(), "new");

        let begun = Unfinished::copy_of(&whole, draft.clone()).unwrap();
        assert_eq!(fs::read_to_string(begun.path()).unwrap(), "new");
        drop(begun);
        assert!(whole.exists() && !draft.exists());
    }
}

//! A cache of solved presses on the disk.
//!
//! An entry's name is a digest of everything that determines the solution: gel, material, contact, indenter, mesh, every
//! pose and the solver itself. A scene that differs only in camera, pattern or light uses the same entry. Entries are
//! written completely or not at all, and checked when they are read: a damaged one counts as absent.

mod entry;

use std::ffi::OsStr;
use std::fmt::Write as _;
use std::fs;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use fingervision_elastic::SurfaceState;
use sha2::{Digest, Sha256};
use tempfile::NamedTempFile;

/// Environment variable with the folder of the cache; without it the platform's folder for caches is used.
const VARIABLE: &str = "FINGERVISION_CACHE";
const EXTENSION: &str = "press";
/// Above this size the oldest entries are removed, bytes: some 400 fine presses.
const MOST_BYTES: u64 = 2 << 30;

/// Where solved presses are kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PressCache {
    /// Absent: no cache.
    folder: Option<PathBuf>,
}

/// An error of the cache. A press can be solved nevertheless.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CacheError {
    /// An entry is damaged.
    #[error("{} in the cache of solved presses is damaged", path.display())]
    Damaged {
        /// The entry.
        path: PathBuf,
    },
    /// The system refuses to read or write.
    #[error("the cache of solved presses cannot be used: {}: {error}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The system's message.
        error: io::Error,
    },
}

/// The size of a cache.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CacheSize {
    /// Solved presses.
    pub entries: usize,
    /// Their files, bytes.
    pub bytes: u64,
}

/// The digest of everything that determines a press's solution.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct PressKey(String);

impl PressKey {
    /// The key of a press whose solution is determined by these texts and files, in this order.
    pub(super) fn of<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> Self {
        let mut digest = Sha256::new();
        for part in parts {
            digest.update((part.len() as u64).to_le_bytes());
            digest.update(part);
        }
        let mut name = String::new();
        for byte in digest.finalize() {
            // Writing to a String cannot fail.
            let _ = write!(name, "{byte:02x}");
        }
        Self(name)
    }
}

impl PressCache {
    /// No cache: every press is solved.
    pub const OFF: Self = Self { folder: None };

    /// A cache in this folder, which is created when the first press is stored.
    #[must_use]
    pub fn at(folder: impl Into<PathBuf>) -> Self {
        Self { folder: Some(folder.into()) }
    }

    /// The cache in the folder given by `FINGERVISION_CACHE`, otherwise in the platform's folder for caches;
    /// [`PressCache::OFF`] if there is none.
    #[must_use]
    pub fn standard() -> Self {
        let named = std::env::var_os(VARIABLE).filter(|folder| !folder.is_empty()).map(PathBuf::from);
        Self { folder: named.or_else(|| Some(dirs::cache_dir()?.join("fingervision"))) }
    }

    /// Its folder; absent for [`PressCache::OFF`].
    #[must_use]
    pub fn folder(&self) -> Option<&Path> {
        self.folder.as_deref()
    }

    /// Its size; zero if it cannot be read.
    #[must_use]
    pub fn size(&self) -> CacheSize {
        let files = self.folder().map(files).unwrap_or_default();
        CacheSize { entries: files.len(), bytes: files.iter().map(|file| file.bytes).sum() }
    }

    /// The surfaces of a press; absent if it was never solved.
    ///
    /// # Errors
    ///
    /// [`CacheError`] if the entry cannot be read or is damaged.
    pub(super) fn load(&self, key: &PressKey) -> Result<Option<Vec<SurfaceState>>, CacheError> {
        let Some(path) = self.path(key) else { return Ok(None) };
        match fs::read(&path) {
            Ok(bytes) => entry::from_bytes(&bytes).map(Some).ok_or(CacheError::Damaged { path }),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(CacheError::Io { path, error }),
        }
    }

    /// Stores the surfaces of a press and removes the oldest entries if there are too many.
    ///
    /// # Errors
    ///
    /// [`CacheError::Io`] if the entry cannot be written; then there is none.
    pub(super) fn store(&self, key: &PressKey, states: &[SurfaceState]) -> Result<(), CacheError> {
        let (Some(folder), Some(path)) = (self.folder(), self.path(key)) else { return Ok(()) };
        let write = || {
            fs::create_dir_all(folder)?;
            let mut file = NamedTempFile::new_in(folder)?;
            file.write_all(&entry::to_bytes(states))?;
            file.persist(&path)?;
            Ok(())
        };
        write().map_err(|error| CacheError::Io { path: folder.to_owned(), error })?;
        make_room(folder, MOST_BYTES);
        Ok(())
    }

    fn path(&self, key: &PressKey) -> Option<PathBuf> {
        Some(self.folder.as_ref()?.join(&key.0).with_extension(EXTENSION))
    }
}

struct File {
    path: PathBuf,
    bytes: u64,
    written: SystemTime,
}

/// The entries in a folder; those removed meanwhile are skipped.
fn files(folder: &Path) -> Vec<File> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let paths = entries.map(|entry| entry.path()).filter(|path| path.extension() == Some(OsStr::new(EXTENSION)));
    let file = |path: PathBuf| {
        let metadata = fs::metadata(&path).ok()?;
        Some(File { bytes: metadata.len(), written: metadata.modified().ok()?, path })
    };
    paths.filter_map(file).collect()
}

/// Removes the oldest entries until the rest takes at most this many bytes.
fn make_room(folder: &Path, most_bytes: u64) {
    let mut files = files(folder);
    files.sort_by_key(|file| file.written);
    let mut bytes: u64 = files.iter().map(|file| file.bytes).sum();
    for file in files {
        if bytes <= most_bytes {
            return;
        }
        // Another process may have been faster; the entry is gone either way.
        let _ = fs::remove_file(&file.path);
        bytes -= file.bytes;
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::scene::stub::bump;

    fn key(name: &str) -> PressKey {
        PressKey::of([name.as_bytes()])
    }

    #[test]
    fn what_is_stored_is_found_under_its_key_alone() {
        let folder = tempfile::tempdir().unwrap();
        let cache = PressCache::at(folder.path().join("presses"));
        assert_eq!(cache.load(&key("a")).unwrap(), None);
        cache.store(&key("a"), &[bump(0.5)]).unwrap();
        assert_eq!(cache.load(&key("a")).unwrap(), Some(vec![bump(0.5)]));
        assert_eq!(cache.load(&key("b")).unwrap(), None);
        assert_eq!(cache.size().entries, 1);
        assert_eq!(fs::read_dir(cache.folder().unwrap()).unwrap().count(), 1, "no temporary file stays");
    }

    #[test]
    fn parts_of_a_key_do_not_run_together() {
        let of = |parts: &[&str]| PressKey::of(parts.iter().map(|part| part.as_bytes()));
        assert_ne!(of(&["ab", "c"]), of(&["a", "bc"]));
        assert_eq!(of(&["ab", "c"]), of(&["ab", "c"]));
    }

    #[test]
    fn a_damaged_entry_differs_from_an_absent_one() {
        let folder = tempfile::tempdir().unwrap();
        let cache = PressCache::at(folder.path());
        cache.store(&key("a"), &[bump(0.5)]).unwrap();
        let path = cache.path(&key("a")).unwrap();
        let whole = fs::read(&path).unwrap();
        fs::write(&path, &whole[..whole.len() - 1]).unwrap();
        assert!(matches!(cache.load(&key("a")), Err(CacheError::Damaged { .. })));
    }

    #[test]
    fn a_cache_that_is_off_keeps_nothing() {
        PressCache::OFF.store(&key("a"), &[bump(0.5)]).unwrap();
        assert_eq!(PressCache::OFF.load(&key("a")).unwrap(), None);
        assert_eq!(PressCache::OFF.size(), CacheSize::default());
    }

    #[test]
    fn a_folder_that_cannot_be_made_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let taken = folder.path().join("taken");
        fs::write(&taken, "a file").unwrap();
        let error = PressCache::at(&taken).store(&key("a"), &[bump(0.5)]).unwrap_err();
        assert!(error.to_string().contains("taken"), "{error}");
    }

    #[test]
    fn the_oldest_entries_make_room() {
        let folder = tempfile::tempdir().unwrap();
        let cache = PressCache::at(folder.path());
        for (age, name) in ["a", "b", "c"].into_iter().enumerate() {
            cache.store(&key(name), &[bump(0.5)]).unwrap();
            let file = fs::File::options().append(true).open(cache.path(&key(name)).unwrap()).unwrap();
            file.set_modified(SystemTime::UNIX_EPOCH + Duration::from_secs(age as u64)).unwrap();
        }
        make_room(folder.path(), cache.size().bytes - 1);
        let is_kept = ["a", "b", "c"].map(|name| cache.load(&key(name)).unwrap().is_some());
        assert_eq!(is_kept, [false, true, true]);
    }
}

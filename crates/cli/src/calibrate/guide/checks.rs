//! Results of the checks of recordings, stored in the sensor's folder: a recording that has not changed is not checked
//! again.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use fingervision_calibrate::check::RecordingCheck;
use fingervision_sink::write_file;
use serde::{Deserialize, Serialize};

/// Its file in the sensor's folder.
const FILE: &str = "checks.json";

/// The key of a check: everything that it depends on, which is the recording's files, their sizes and times, and the
/// settings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Key(u64);

#[derive(Debug, Serialize, Deserialize)]
struct Kept {
    key: Key,
    check: RecordingCheck,
}

/// The checks, by the names of their recordings.
#[derive(Debug)]
pub(super) struct Checks {
    path: PathBuf,
    kept: BTreeMap<String, Kept>,
    has_changed: bool,
}

impl Key {
    /// For these settings and recordings.
    pub(super) fn of<'a>(settings: &str, recordings: impl Iterator<Item = &'a Path>) -> Self {
        let mut hasher = DefaultHasher::new();
        (env!("CARGO_PKG_VERSION"), settings).hash(&mut hasher);
        for recording in recordings {
            for folder in [recording.to_owned(), recording.join("frames"), recording.join("truth")] {
                files(&folder).hash(&mut hasher);
            }
        }
        Self(hasher.finish())
    }
}

/// Name, size and time of the last change, s and ns, of every file in a folder.
fn files(folder: &Path) -> Vec<(OsString, u64, u64, u32)> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<_> = entries
        .filter_map(|entry| {
            let about = fs::metadata(entry.path()).ok().filter(fs::Metadata::is_file)?;
            let changed = about.modified().ok().and_then(|time| time.duration_since(UNIX_EPOCH).ok())?;
            Some((entry.file_name(), about.len(), changed.as_secs(), changed.subsec_nanos()))
        })
        .collect();
    files.sort();
    files
}

impl Checks {
    /// The checks of a sensor's folder; none if there are none or they cannot be read.
    pub(super) fn load(folder: &Path) -> Self {
        let path = folder.join(FILE);
        let kept = fs::read_to_string(&path).ok().and_then(|text| serde_json::from_str(&text).ok());
        Self { path, kept: kept.unwrap_or_default(), has_changed: false }
    }

    /// The result for a recording, if it was checked under this key.
    pub(super) fn of(&self, recording: &Path, key: Key) -> Option<RecordingCheck> {
        self.kept.get(&name(recording)).filter(|kept| kept.key == key).map(|kept| kept.check.clone())
    }

    /// Stores a result.
    pub(super) fn keep(&mut self, recording: &Path, key: Key, check: &RecordingCheck) {
        self.kept.insert(name(recording), Kept { key, check: check.clone() });
        self.has_changed = true;
    }

    /// Writes the file. If that fails, the next run checks again.
    pub(super) fn save(&self) {
        if self.has_changed
            && let Ok(text) = serde_json::to_string_pretty(&self.kept)
        {
            let _ = write_file(&self.path, text.as_bytes());
        }
    }
}

fn name(recording: &Path) -> String {
    recording.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

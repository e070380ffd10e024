//! Errors of writing and opening a recording.

use std::io;
use std::path::{Path, PathBuf};

/// Why a recording cannot be written or opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// The file cannot be written: the disk is full or was removed. What was written before can be read.
    #[error("{}: cannot be written: {error}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's message.
        error: io::Error,
    },
    /// The file cannot be read.
    #[error("{}: cannot be read: {error}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's message.
        error: io::Error,
    },
    /// The file is not a recording, or it ends before its first record.
    #[error("{}: not a recording: {reason}", path.display())]
    NotARecording {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
    /// The recording has no such sensor, or several of which one must be named.
    #[error("{}: {}", path.display(), no_sensor(wanted.as_deref(), sensors))]
    Sensor {
        /// The file.
        path: PathBuf,
        /// The sensor that was named, if one was.
        wanted: Option<String>,
        /// The sensors that it has.
        sensors: Vec<String>,
    },
    /// A thread for writing cannot be started.
    #[error("{}: a thread for writing cannot be started: {error}", path.display())]
    Thread {
        /// The file.
        path: PathBuf,
        /// The system's message.
        error: io::Error,
    },
}

fn no_sensor(wanted: Option<&str>, sensors: &[String]) -> String {
    match wanted {
        Some(wanted) => format!("there is no sensor {wanted} in it, only {}", sensors.join(", ")),
        None => format!("it has {} sensors: {}", sensors.len(), sensors.join(", ")),
    }
}

impl RecordingError {
    /// What the user can do about it.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::Write { error, .. } => match error.kind() {
                io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
                    "free some space, or record to another disk; what was recorded so far can be read".into()
                }
                io::ErrorKind::FileTooLarge => {
                    "the file system (FAT: 4 GB) or `ulimit -f` allows no longer file: record to another \
                     disk; what was recorded so far can be read"
                        .into()
                }
                _ => "check that the folder exists and can be written".into(),
            },
            Self::Read { .. } => "check that the file exists and is readable".into(),
            Self::NotARecording { .. } => {
                "recordings are MCAP files that `fingervision record` or `fingervision live --record` wrote".into()
            }
            Self::Sensor { path, sensors, .. } => {
                let first = sensors.first().map_or("NAME", String::as_str);
                format!("name one of them, as in '{}?sensor={first}'", path.display())
            }
            Self::Thread { .. } => "close other programs, or raise the limit of `ulimit -u`".into(),
        }
    }

    pub(crate) fn writing(path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |error| Self::Write { path: path.to_owned(), error }
    }

    pub(crate) fn reading(path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |error| Self::Read { path: path.to_owned(), error }
    }
}

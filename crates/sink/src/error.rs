use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// Why a reading could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SinkError {
    /// The folder contains the output of an earlier command and overwriting was not requested.
    #[error("folder {} contains a previous {noun}", .path.display())]
    Previous {
        /// The folder.
        path: PathBuf,
        /// Its content: a run, a simulation.
        noun: &'static str,
    },
    /// The folder contains something else, so nothing in it may be replaced.
    #[error("folder {} contains files that are not a {noun}", .path.display())]
    FolderNotEmpty {
        /// The folder.
        path: PathBuf,
        /// The kind of output that was to be written there.
        noun: &'static str,
    },
    /// Another command is writing into the folder.
    #[error("folder {} is being written by another command", .path.display())]
    Busy {
        /// The folder.
        path: PathBuf,
    },
    /// The operating system refused to create, write or remove a file or folder.
    #[error("cannot write {}: {error}", .path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// The system's message.
        error: io::Error,
    },
    /// The operating system refused to read a file of a run.
    #[error("cannot read {}: {error}", .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's message.
        error: io::Error,
    },
    /// Something that is not a run, where one is needed.
    #[error("{} is not a run: {reason}", .path.display())]
    NotARun {
        /// The folder or file.
        path: PathBuf,
        /// What is missing or wrong.
        reason: String,
    },
    /// A field has another size than the run began with.
    #[error("{field} has {}x{} px, expected {}x{} px", .actual.0, .actual.1, .expected.0, .expected.1)]
    SizeMismatch {
        /// The field's name.
        field: &'static str,
        /// Columns and rows of the run, px.
        expected: (usize, usize),
        /// Columns and rows of the field, px.
        actual: (usize, usize),
    },
    /// A reading lacks a field that is to be written.
    #[error("frame {sequence} has no {field}")]
    FieldAbsent {
        /// The field's name.
        field: &'static str,
        /// The frame's number in its source.
        sequence: u64,
    },
    /// The format is not part of this program.
    #[error("{}: this program was built without {what}", .path.display())]
    NotBuilt {
        /// The file.
        path: PathBuf,
        /// The format.
        what: &'static str,
    },
    /// There is nothing to draw: no reading was written.
    #[error("no frame was read, so there is nothing to draw")]
    NoReadings,
}

impl SinkError {
    /// What the user can do about it, if anything.
    #[must_use]
    pub fn hint(&self) -> Option<&'static str> {
        match self {
            Self::Previous { .. } => Some("choose a new folder or pass --overwrite"),
            Self::Busy { .. } => Some("wait until the other command ends, or choose another folder"),
            Self::FolderNotEmpty { .. } => Some("choose a new or an empty folder"),
            Self::Write { path, error } => Some(hint_for(error.kind(), path)),
            Self::Read { .. } => Some("check that the run is complete and readable"),
            Self::NotARun { .. } => Some("give a folder of `fingervision track`"),
            Self::SizeMismatch { .. } => Some("start a new run for every size of image"),
            Self::FieldAbsent { .. } => Some("leave the field out of --fields, or calibrate the profile for it"),
            Self::NotBuilt { .. } => {
                Some("name it .avi, or build the program with `cargo install --path crates/cli --features mp4`")
            }
            Self::NoReadings => Some("check that the source provides frames"),
        }
    }

    /// Adds the file's name to the system's message.
    pub fn writing(path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |error| Self::Write { path: path.to_path_buf(), error }
    }
}

/// Formats of files that can be read while they grow.
const GROWING: [&str; 3] = ["npy", "csv", "avi"];

fn hint_for(kind: ErrorKind, path: &Path) -> &'static str {
    let grows = path.extension().is_some_and(|ending| GROWING.iter().any(|growing| ending == *growing));
    match kind {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded if grows => {
            "free some space or choose a folder on another disk; what was written so far can be read"
        }
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "free some space or choose a folder on another disk",
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => "choose a writable folder",
        ErrorKind::AlreadyExists | ErrorKind::NotADirectory => "there is a file of that name: choose another folder",
        ErrorKind::NotFound => "make the folder first",
        ErrorKind::IsADirectory => "name a file in the folder",
        _ => "check the folder and its disk",
    }
}

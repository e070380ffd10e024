//! Why a camera cannot be used.

use std::io;
use std::path::PathBuf;

use fingervision_source::SourceError;

use crate::Mode;

/// Numbers of the system's errors, the same on every Linux.
pub(crate) const NO_SPACE: i32 = 28;
const BUSY: i32 = 16;
const NO_DEVICE: [i32; 2] = [19, 6];

/// Why a camera cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CameraError {
    /// No camera is plugged in.
    #[error("no camera found")]
    NoCamera,
    /// No camera has this id, serial number or name.
    #[error("no camera matches {wanted:?}")]
    NotFound {
        /// The text that was given.
        wanted: String,
        /// The ids of the cameras that are there.
        present: Vec<String>,
    },
    /// More than one camera matches.
    #[error("{}: {}", several(wanted.as_deref()), matches.join(", "))]
    Ambiguous {
        /// The text that was given; absent if there was none.
        wanted: Option<String>,
        /// The ids of the cameras that match.
        matches: Vec<String>,
    },
    /// The camera was named by a number, which can change when cameras are plugged in.
    #[error("{wanted:?} is a number, which can change when a device is plugged in")]
    Number {
        /// The text that was given.
        wanted: String,
        /// The id of the camera that currently has this number.
        now: Option<String>,
    },
    /// The user lacks the permission to open the camera.
    #[error("{camera}: no permission to open {}", node.display())]
    Denied {
        /// The camera's id.
        camera: String,
        /// Its node.
        node: PathBuf,
    },
    /// Another program captures from the camera.
    #[error("{camera}: busy, another program uses it")]
    Busy {
        /// The camera's id.
        camera: String,
        /// Its node.
        node: PathBuf,
    },
    /// The camera does not offer the mode that the profile requests.
    #[error("{camera} does not offer {wanted}")]
    NotOffered {
        /// The camera's id.
        camera: String,
        /// The mode, in words.
        wanted: String,
        /// What it offers, in words.
        offered: Vec<String>,
    },
    /// The USB port has no bandwidth left for the mode.
    #[error("{camera}: not enough USB bandwidth for {mode}")]
    NoBandwidth {
        /// The camera's id.
        camera: String,
        /// The mode.
        mode: Mode,
    },
    /// The camera was unplugged.
    #[error("{camera}: unplugged")]
    Unplugged {
        /// The camera's id.
        camera: String,
    },
    /// The camera sends no frames.
    #[error("{camera}: no frame in {waited_s:.1} s")]
    TimedOut {
        /// The camera's id.
        camera: String,
        /// How long, s.
        waited_s: f64,
    },
    /// The system reports an error.
    #[error("{camera}: {doing}: {error}")]
    Io {
        /// The camera's id.
        camera: String,
        /// The operation that failed, as in `open`.
        doing: &'static str,
        /// The system's message.
        error: io::Error,
    },
}

impl CameraError {
    /// What the user can do about it.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::NoCamera if cfg!(target_os = "linux") => {
                "plug it in, look for it in the output of `lsusb`, and try another port or cable; in a container, \
                 /dev/video* must be passed in"
                    .into()
            }
            Self::NoCamera => "cameras are supported on Linux only; record a video and track that".into(),
            Self::NotFound { present, .. } if present.is_empty() => {
                "no camera is plugged in: look for it in the output of `lsusb`, and try another port or cable".into()
            }
            Self::NotFound { present, .. } => format!("cameras present: {}", present.join(", ")),
            Self::Ambiguous { .. } => "give the whole id of one of them, or its serial number".into(),
            Self::Number { now: Some(id), .. } => format!("now it is the camera {id}: use this id"),
            Self::Number { now: None, .. } => "`fingervision doctor` lists the ids of all cameras".into(),
            Self::Denied { .. } => {
                "add yourself to the group video, `sudo usermod -aG video $USER`, then log out and in again".into()
            }
            Self::Busy { node, .. } => format!("close it; `fuser -v {}` names the program", node.display()),
            Self::NotOffered { offered, .. } => format!("it offers {}", offered.join("; ")),
            Self::NoBandwidth { .. } => {
                "use MJPG instead of a raw format, a smaller size or a lower rate, or plug the camera into a port of \
                 another USB controller; `fingervision doctor` shows what each port has left"
                    .into()
            }
            Self::Unplugged { .. } => "plug it in again; check the cable".into(),
            Self::TimedOut { .. } => {
                "unplug it and plug it in again; if it happens often, use a shorter cable or a port without a hub"
                    .into()
            }
            Self::Io { .. } => {
                "unplug the camera and plug it in again; `dmesg` shows the messages of the system".into()
            }
        }
    }

    /// Converts an error of the system into that of this camera.
    pub(crate) fn io(camera: &str, node: PathBuf, doing: &'static str, error: io::Error) -> Self {
        let camera = camera.to_owned();
        match error.raw_os_error() {
            _ if error.kind() == io::ErrorKind::PermissionDenied => Self::Denied { camera, node },
            Some(BUSY) => Self::Busy { camera, node },
            _ => Self::Io { camera, doing, error },
        }
    }
}

impl From<CameraError> for SourceError {
    fn from(error: CameraError) -> Self {
        Self::Camera { hint: error.hint(), reason: error.to_string() }
    }
}

/// Whether the error means that the camera is missing.
pub(crate) fn is_gone(error: &io::Error) -> bool {
    let is_absent = error.kind() == io::ErrorKind::NotFound;
    is_absent || error.raw_os_error().is_some_and(|number| NO_DEVICE.contains(&number))
}

fn several(wanted: Option<&str>) -> String {
    match wanted {
        Some(wanted) => format!("{wanted:?} matches several cameras"),
        None => "there are several cameras, and none is selected".into(),
    }
}

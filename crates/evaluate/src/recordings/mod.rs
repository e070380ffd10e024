//! Recorded pairs and presses.
//!
//! The recordings are not part of the project; [`Recordings::find`] describes the folders that are searched. They are:
//!
//! - whole-pixel shifts and two samples of the *DIC Challenge* 1.0, whose motion is known by construction;
//! - *`RubberWhale`* of the Middlebury benchmark, with dense truth;
//! - a press on a Punyo sensor: an air-filled membrane with a dense speckle, seen from inside, with a depth camera's
//!   image and the force of the robot's wrist beside every frame. It has no dense truth. Instead, three properties are
//!   checked: the flow of the membrane at rest is zero, the flow to a frame and back to the reference adds up to zero,
//!   and the flow grows with the force;
//! - three presses from another finite-element program and renderer, with its truth of depth and force.

mod files;
mod independent;
mod pairs;
mod press;
mod punyo;

pub use independent::measure as measure_independent;
pub use pairs::measure as measure_pairs;
pub use press::PressEvidence;
pub use punyo::Punyo;

use std::path::{Path, PathBuf};

/// The folder of recordings.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recordings {
    folder: PathBuf,
}

/// The environment variable that names the folder of recordings.
pub const FOLDER_VARIABLE: &str = "FINGERVISION_DATA";

impl Recordings {
    /// The recordings in the folder that [`FOLDER_VARIABLE`] names, or else in `../shared/data` beside the workspace.
    /// `None` if this folder does not exist.
    #[must_use]
    pub fn find(workspace: &Path) -> Option<Self> {
        let named = std::env::var_os(FOLDER_VARIABLE).map(PathBuf::from);
        let folder = named.unwrap_or_else(|| workspace.join("../shared/data"));
        folder.is_dir().then_some(Self { folder })
    }

    fn path(&self, file: &str) -> PathBuf {
        self.folder.join(file)
    }
}

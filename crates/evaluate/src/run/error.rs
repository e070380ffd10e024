//! Why a run cannot be compared with its truth.

use std::io;
use std::path::{Path, PathBuf};

use fingervision_image::Rect;
use fingervision_optics::CameraError;
use fingervision_settings::SettingsError;

/// Why a run cannot be compared with its truth.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// A folder that contains neither flow nor depth.
    #[error("{}: {}", .folder.display(), if .folder.is_dir() { "it contains neither flow.npy nor depth.npy" } else { "there is no such folder" })]
    NoFields {
        /// The folder.
        folder: PathBuf,
        /// Which folders can be given.
        hint: String,
    },
    /// A file that exists, but cannot be read.
    #[error("cannot read {}: {error}", .file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// The error of the operating system.
        error: io::Error,
    },
    /// An array with an unexpected type or shape, or one that is incomplete.
    #[error("{}: {reason}", .file.display())]
    Array {
        /// The file.
        file: PathBuf,
        /// What was found and what was expected.
        reason: String,
        /// What to do about it.
        hint: String,
    },
    /// A table without a required column, or with a cell that is not a number.
    #[error("{}, line {line}: {reason}", .file.display())]
    Table {
        /// The file.
        file: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// What was found and what was expected.
        reason: String,
    },
    /// A `run.toml` or `profile.toml` with an error.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// An impossible camera.
    #[error("{}: camera.{error}", .file.display())]
    Camera {
        /// The truth's `profile.toml`.
        file: PathBuf,
        /// What is wrong with it.
        error: CameraError,
    },
    /// A region of interest whose size differs from that of the arrays.
    #[error("{}: the region of interest {} differs in size from the arrays, {}x{} px", .file.display(), shown(.region), .size.0, .size.1)]
    Region {
        /// The file that contains the region.
        file: PathBuf,
        /// The region.
        region: Rect,
        /// Columns and rows of the arrays, px.
        size: (usize, usize),
    },
    /// A run whose pixels differ from those of the truth.
    #[error("the run's grid {} is not inside the truth's grid {}", shown(.run), shown(.truth))]
    Grids {
        /// Position of the run's fields in the camera image.
        run: Rect,
        /// Position of the truth's fields in the camera image.
        truth: Rect,
    },
    /// Files with different numbers of frames.
    #[error("{} contains {} frames, {} contains {}", .first.0.display(), .first.1, .second.0.display(), .second.1)]
    FrameCounts {
        /// A file and its frames.
        first: (PathBuf, u64),
        /// Another file and its frames.
        second: (PathBuf, u64),
    },
    /// Nothing to compare.
    #[error("{} contains {run_holds} and {} contains {truth_holds}: there is nothing to compare", .run.display(), .truth.display())]
    NothingInCommon {
        /// The run's folder.
        run: PathBuf,
        /// Its fields.
        run_holds: String,
        /// The folder of the truth.
        truth: PathBuf,
        /// Its fields.
        truth_holds: String,
    },
    /// A run and a truth of different scenes.
    #[error("{} was tracked from the scene \"{run_scene}\", but {} is the truth of \"{truth_scene}\"", .run.display(), .truth.display())]
    OtherScene {
        /// The run's folder.
        run: PathBuf,
        /// The scene that its frames show.
        run_scene: String,
        /// The folder of the truth.
        truth: PathBuf,
        /// The scene of the truth.
        truth_scene: String,
    },
    /// A pixel that is marked as valid, but is not finite.
    #[error("{}: frame {frame}, pixel ({x}, {y}) is not finite, but {mask} marks it as valid", .file.display())]
    NotFinite {
        /// The array.
        file: PathBuf,
        /// The name of the mask.
        mask: &'static str,
        /// The frame, counted from 0.
        frame: u64,
        /// The pixel's column.
        x: usize,
        /// The pixel's row.
        y: usize,
    },
}

impl RunError {
    /// What the user can do about it.
    #[must_use]
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::NoFields { hint, .. } | Self::Array { hint, .. } => Some(hint.clone()),
            Self::Read { .. } => Some("check that the file exists and can be read".into()),
            Self::Table { .. } => {
                Some("a table has a line of column names, then one line of numbers per frame, with decimal points, separated by commas".into())
            }
            Self::Settings(error) => {
                error.hint().or_else(|| Some("check that the file exists and can be read".into()))
            }
            Self::Camera { error, .. } => Some(format!("set camera.{} there to {}", error.key, error.allowed)),
            Self::Region { .. } => {
                Some("correct image.region_of_interest = [x, y, width, height] there, or leave [image] out".into())
            }
            Self::Grids { .. } => Some(
                "give the truth of exactly these frames; if only a part of the image was tracked, run.toml must contain \
                 profile.image.region_of_interest = [x, y, width, height]"
                    .into(),
            ),
            Self::FrameCounts { .. } => Some("--common-frames compares only the first frames, which all files contain".into()),
            Self::OtherScene { run_scene, .. } => {
                Some(format!("give the folder of the simulation \"{run_scene}\" whose frames were tracked"))
            }
            Self::NothingInCommon { .. } => {
                Some("track with --fields flow,depth, or give a truth with the fields of the run".into())
            }
            Self::NotFinite { mask, .. } => {
                Some(format!("set {mask} to 0 where nothing was measured, or leave it out"))
            }
        }
    }

    /// Adds the file to an error of the operating system.
    pub(super) fn reading(file: &Path) -> impl FnOnce(io::Error) -> Self {
        move |error| Self::Read { file: file.to_owned(), error }
    }
}

fn shown(Rect { x, y, width, height }: &Rect) -> String {
    format!("[{x}, {y}, {width}, {height}]")
}

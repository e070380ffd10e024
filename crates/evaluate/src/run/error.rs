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
    /// A folder that holds neither flow nor depth.
    #[error("{} holds neither flow.npy nor depth.npy", .folder.display())]
    NoFields {
        /// The folder.
        folder: PathBuf,
        /// What would have been a folder of this kind.
        hint: String,
    },
    /// A file that is there, but cannot be read.
    #[error("cannot read {}: {error}", .file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the operating system said.
        error: io::Error,
    },
    /// An array of another kind or shape than its name says, or one that was cut short.
    #[error("{}: {reason}", .file.display())]
    Array {
        /// The file.
        file: PathBuf,
        /// What was found and what was expected.
        reason: String,
        /// What to do about it.
        hint: String,
    },
    /// A table that lacks a column or holds what is no number.
    #[error("{}, line {line}: {reason}", .file.display())]
    Table {
        /// The file.
        file: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// What was found and what was expected.
        reason: String,
    },
    /// A `run.toml` or `profile.toml` that does not say what it should.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// A camera that cannot be.
    #[error("{}: camera.{error}", .file.display())]
    Camera {
        /// The truth's `profile.toml`.
        file: PathBuf,
        /// What is wrong with it.
        error: CameraError,
    },
    /// A region of interest of another size than the arrays that it is said of.
    #[error("{}: the region of interest {} is not the {}x{} px of the arrays", .file.display(), shown(.region), .size.0, .size.1)]
    Region {
        /// The file that names the region.
        file: PathBuf,
        /// The region.
        region: Rect,
        /// Columns and rows of the arrays, px.
        size: (usize, usize),
    },
    /// A run whose pixels differ from those of the truth.
    #[error("the run's grid {} is no part of the truth's {}", shown(.run), shown(.truth))]
    Grids {
        /// Where the run's fields lie in the camera image.
        run: Rect,
        /// Where the truth's fields lie in the camera image.
        truth: Rect,
    },
    /// Files that count different numbers of frames.
    #[error("{} counts {} frames, {} counts {}", .first.0.display(), .first.1, .second.0.display(), .second.1)]
    FrameCounts {
        /// A file and its frames.
        first: (PathBuf, u64),
        /// Another file and its frames.
        second: (PathBuf, u64),
    },
    /// Nothing to compare.
    #[error("{} holds {run_holds} and {} holds {truth_holds}: there is nothing to compare", .run.display(), .truth.display())]
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
    /// A run that was tracked from another scene than the truth is of.
    #[error("{} was tracked from the scene \"{run_scene}\", but {} is the truth of \"{truth_scene}\"", .run.display(), .truth.display())]
    OtherScene {
        /// The run's folder.
        run: PathBuf,
        /// The scene that its frames show.
        run_scene: String,
        /// The folder of the truth.
        truth: PathBuf,
        /// The scene that it is of.
        truth_scene: String,
    },
    /// A pixel that counts as valid, but has no number.
    #[error("{}: frame {frame}, pixel ({x}, {y}) is not finite, but {mask} says that it holds", .file.display())]
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
    /// What the person at the keyboard can do about it.
    #[must_use]
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::NoFields { hint, .. } | Self::Array { hint, .. } => Some(hint.clone()),
            Self::Read { .. } => Some("check that the file is there and may be read".into()),
            Self::Table { .. } => {
                Some("a table has a line of column names, then a line of numbers a frame, separated by commas".into())
            }
            Self::Settings(error) => {
                error.hint().or_else(|| Some("check that the file is there and may be read".into()))
            }
            Self::Camera { error, .. } => Some(format!("set camera.{} there to {}", error.key, error.allowed)),
            Self::Region { .. } => {
                Some("correct image.region_of_interest = [x, y, width, height] there, or leave [image] out".into())
            }
            Self::Grids { .. } => Some(
                "give the truth of these very frames; a run on a part of the image says so in its run.toml: \
                 profile.image.region_of_interest = [x, y, width, height]"
                    .into(),
            ),
            Self::FrameCounts { .. } => Some("--common-frames compares the first frames, those that all hold".into()),
            Self::OtherScene { run_scene, .. } => {
                Some(format!("give the folder of the simulation \"{run_scene}\" whose frames were tracked"))
            }
            Self::NothingInCommon { .. } => {
                Some("track with --fields flow,depth, or give the truth of what the run holds".into())
            }
            Self::NotFinite { mask, .. } => {
                Some(format!("set {mask} to 0 where nothing was measured, or leave it out"))
            }
        }
    }

    /// Names the file in what the operating system said.
    pub(super) fn reading(file: &Path) -> impl FnOnce(io::Error) -> Self {
        move |error| Self::Read { file: file.to_owned(), error }
    }
}

fn shown(Rect { x, y, width, height }: &Rect) -> String {
    format!("[{x}, {y}, {width}, {height}]")
}

//! Errors of opening and reading a source.

use crate::FrameFormat;
use std::io;
use std::path::{Path, PathBuf};

/// The supported formats, for hints.
#[cfg(not(feature = "video"))]
const READ: &str =
    "folders of PNG, JPEG, TIFF or BMP images and recordings (MCAP) are read, and camera:ID and sim:SCENE";

/// The supported formats, for hints.
#[cfg(feature = "video")]
const READ: &str = "folders of PNG, JPEG, TIFF or BMP images, videos (H.264 in MP4 or MOV, motion JPEG in AVI, MP4 or MOV) and \
                    recordings (MCAP) are read, and camera:ID and sim:SCENE";

/// Why a source cannot be opened or read further.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SourceError {
    /// There is nothing at the path.
    #[error("{}: no such file or folder", path.display())]
    NotFound {
        /// The requested path.
        path: PathBuf,
    },
    /// The system refuses to read a file or folder.
    #[error("{}: {}", path.display(), error.kind())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The system's message.
        error: io::Error,
    },
    /// A format that is not supported, or not yet.
    #[error("{}: {what} is not supported", path.display())]
    NotRead {
        /// The file, folder or name.
        path: PathBuf,
        /// The actual content, as a noun.
        what: String,
        /// What to do instead.
        hint: String,
    },
    /// Fewer than two frames: tracking needs a reference and at least one more.
    #[error("{}: {}: tracking needs a reference and at least one more", path.display(), counted(*count))]
    TooFewFrames {
        /// The folder or video file.
        path: PathBuf,
        /// Number of frames.
        count: u64,
    },
    /// A video file whose index is damaged or missing, so that no frame can be found.
    #[error("{}: {reason}", path.display())]
    Container {
        /// The video file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A frame that is damaged or cut off.
    #[error("{}: frame {sequence}: {reason}", path.display())]
    Frame {
        /// The image or video file.
        path: PathBuf,
        /// The frame's number in its source, from 0.
        sequence: u64,
        /// What is wrong with it.
        reason: String,
    },
    /// A floating-point pixel outside 0 to 1, or not a number.
    #[error("{}: frame {sequence}: pixel ({x}, {y}) is {value}, not within 0 to 1", path.display())]
    PixelRange {
        /// The image file.
        path: PathBuf,
        /// The frame's number in its source, from 0.
        sequence: u64,
        /// The pixel's column as stored, px.
        x: usize,
        /// The pixel's row as stored, px.
        y: usize,
        /// The value found, dimensionless.
        value: f64,
    },
    /// A frame that differs from the first in size or pixel format.
    #[error("{}: frame {sequence}: {found}, expected {expected} as before", path.display())]
    FormatChanged {
        /// The image or video file.
        path: PathBuf,
        /// The frame's number in its source, from 0.
        sequence: u64,
        /// The frame's format.
        found: FrameFormat,
        /// The format of the first frame.
        expected: FrameFormat,
    },
    /// A simulated scene that is impossible, or cannot be solved.
    #[error("{location}: {reason}")]
    Simulated {
        /// The requested location.
        location: String,
        /// What is wrong.
        reason: String,
        /// What to do about it, if anything.
        hint: Option<String>,
    },
    /// A camera that delivers no more frames.
    #[error("{reason}")]
    Camera {
        /// What is wrong; it names the camera.
        reason: String,
        /// What to do about it.
        hint: String,
    },
    /// An impossible frame rate.
    #[error("{frames_per_second} frames per second: a rate is a number from 1e-6 to 1e6")]
    Rate {
        /// The requested rate, frames per second.
        frames_per_second: f64,
    },
    /// An option of a simulated scene with an invalid value.
    #[error("{location}: {value} is not a number of frames per second")]
    Option {
        /// The requested location.
        location: String,
        /// The given value.
        value: String,
    },
}

impl SourceError {
    /// What the user can do about it, if anything.
    #[must_use]
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::NotFound { .. } => Some(format!("check the name; {READ}")),
            Self::NotRead { hint, .. } | Self::Camera { hint, .. } => Some(hint.clone()),
            Self::TooFewFrames { path, count } => Some(too_few_hint(path, *count)),
            Self::Container { .. } => Some("the recording may not have been closed: record again".into()),
            Self::Frame { sequence: 0, .. } => {
                Some("the first frame must be readable: leave it out, or record again".into())
            }
            Self::Frame { .. } => Some("the frames before it are complete: record it again, or leave it out".into()),
            Self::PixelRange { .. } => Some("scale the images to 0 to 1, or store them with 8 or 16 bit".into()),
            Self::FormatChanged { .. } => {
                Some("keep frames of one size and one pixel format in a folder, and track the others separately".into())
            }
            Self::Simulated { hint, .. } => hint.clone(),
            Self::Io { .. } => Some("check that the file exists and is readable".into()),
            Self::Rate { .. } | Self::Option { .. } => {
                Some("give a number from 1e-6 to 1e6, as in --fps 60 or sim:letter?fps=60".into())
            }
        }
    }

    pub(crate) fn io(path: &Path, error: io::Error) -> Self {
        let path = path.to_owned();
        if error.kind() == io::ErrorKind::NotFound { Self::NotFound { path } } else { Self::Io { path, error } }
    }

    pub(crate) fn not_read_yet(path: &Path, what: &str) -> Self {
        Self::NotRead { path: path.to_owned(), what: what.into(), hint: READ.into() }
    }

    pub(crate) fn no_regular_file(path: &Path) -> Self {
        let hint = "move it out of the folder, or store the images or the video in regular files".into();
        Self::NotRead { path: path.to_owned(), what: "a pipe, socket or device".into(), hint }
    }

    pub(crate) fn single_image(path: &Path) -> Self {
        let hint = "give the folder that holds the images".into();
        Self::NotRead { path: path.to_owned(), what: "a single image".into(), hint }
    }

    pub(crate) fn unread_video(path: &Path, what: String) -> Self {
        Self::NotRead { path: path.to_owned(), what, hint: conversion(path, "") }
    }

    /// A folder of so many images with an ending that is not read.
    pub(crate) fn other_images(folder: &Path, count: usize, ending: &str) -> Self {
        let what = format!("the format of its {count} images, .{ending},");
        let hint = format!("convert them: magick mogrify -format png '{}/*.{ending}'", folder.display());
        Self::NotRead { path: folder.to_owned(), what, hint }
    }

    #[cfg(not(feature = "video"))]
    pub(crate) fn video_left_out(path: &Path) -> Self {
        let hint = "build with the feature `video`, or store the frames as images in a folder".into();
        Self::NotRead { path: path.to_owned(), what: "a video".into(), hint }
    }

    #[cfg(feature = "video")]
    pub(crate) fn interlaced(path: &Path) -> Self {
        let what = "interlaced motion JPEG (two fields a frame)".into();
        Self::NotRead { path: path.to_owned(), what, hint: conversion(path, "-vf yadif ") }
    }
}

/// The command that converts it to a video that is read.
fn conversion(path: &Path, filter: &str) -> String {
    let (input, output) = (path.display(), path.with_extension("h264.mp4"));
    let output = output.display();
    format!("convert it: ffmpeg -i '{input}' {filter}-c:v libx264 -crf 12 -pix_fmt yuv420p -an '{output}'")
}

fn counted(count: u64) -> String {
    match count {
        0 => "no frame".into(),
        1 => "one frame".into(),
        _ => format!("{count} frames"),
    }
}

fn too_few_hint(path: &Path, count: u64) -> String {
    let inside = path.join("frames");
    match count {
        _ if inside.is_dir() => format!("did you mean {}?", inside.display()),
        _ if path.join("scene.toml").is_file() => {
            "this simulation has no camera images: simulate the scene without --truth-only".into()
        }
        0 => READ.into(),
        _ => "record the gel at rest first, then the touch".into(),
    }
}

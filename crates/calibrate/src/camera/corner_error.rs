//! Errors of a camera fit to corners.

use thiserror::Error;

/// Fewer poses do not determine a lens.
pub(super) const LEAST_POSES: usize = 3;
/// Fewer corners do not determine a pose with redundancy.
pub(super) const LEAST_CORNERS: usize = 6;
/// The first line of a file of corners.
pub(super) const HEADER: &str = "image,x_mm,y_mm,u_px,v_px";

/// Why corners do not determine a camera.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CornerError {
    /// The file's first line is not the header.
    #[error("line 1 is not {HEADER}")]
    NoHeader,
    /// The file is not a table.
    #[error("line {line}: {reason}")]
    Table {
        /// The line, counted from 1.
        line: usize,
        /// What is wrong there.
        reason: String,
    },
    /// A line is not five numbers.
    #[error("line {line}: \"{text}\" is not five numbers separated by commas")]
    Line {
        /// The line, counted from 1.
        line: usize,
        /// The line's content.
        text: String,
    },
    /// There are too few images.
    #[error("the corners come from {images} images: at least {LEAST_POSES} are needed")]
    TooFewImages {
        /// Number of them.
        images: usize,
    },
    /// An image has too few corners.
    #[error("image {image} has {corners} corners: at least {LEAST_CORNERS} are needed")]
    TooFewCorners {
        /// The image, counted from 0 in the order of the file.
        image: usize,
        /// Number of them.
        corners: usize,
    },
    /// The corners of an image lie on a line.
    #[error("the corners of an image lie on one line")]
    NoPlane,
    /// The board was parallel to the image in all images.
    #[error("the board is not tilted in any image: its corners do not determine the focal length")]
    NoTilt,
    /// No camera explains the corners.
    #[error("no camera explains the corners: the residual of the best one is {residual_px:.1} px on average")]
    NotConverged {
        /// Mean distance, px.
        residual_px: f64,
    },
}

impl CornerError {
    /// What to do about it.
    #[must_use]
    pub fn hint(&self) -> &'static str {
        match self {
            Self::NoHeader | Self::Table { .. } | Self::Line { .. } => {
                "a row for each corner: the image's number, where the corner is on the board, mm, and in the image, px, with decimal points, below the line image,x_mm,y_mm,u_px,v_px"
            }
            Self::TooFewImages { .. } => "show the board in 5 or more poses, tilted by 15° to 40° to different sides",
            Self::TooFewCorners { .. } | Self::NoPlane => "leave the image out, or detect all its corners",
            Self::NoTilt => "tilt the board by 15° to 40° to different sides",
            Self::NotConverged { .. } => {
                "no profile was written: check the order of the corners, and that x points right and y down on the board"
            }
        }
    }
}

use crate::GelError;

/// An impossible pattern.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PatternError {
    /// A value outside its range.
    #[error("{key} = {value} is impossible: it must be {allowed}")]
    OutOfRange {
        /// Which value, by its name in a scene's `[pattern]` table.
        key: &'static str,
        /// The value, in the unit that its name ends in.
        value: String,
        /// The possible values, with their unit.
        allowed: &'static str,
    },
    /// Dots wider than the distance between neighbours.
    #[error("dots of {diameter_mm} mm overlap: {} by {} of them on {}x{} mm stand {pitch_mm:.4} mm apart", count[0], count[1], size_mm[0], size_mm[1])]
    DotsOverlap {
        /// Diameter of a dot, mm.
        diameter_mm: f64,
        /// Columns and rows of dots.
        count: [usize; 2],
        /// Width and height of the pattern, mm.
        size_mm: [f64; 2],
        /// Distance between the centres of the nearest dots, mm.
        pitch_mm: f64,
    },
    /// More or fewer cells across the pattern than possible.
    #[error("a pattern of {size_mm} mm with {what} of {part_mm} mm has {count} across: 3 to {most} are possible")]
    Count {
        /// The kind of parts, such as "cells".
        what: &'static str,
        /// Length of the pattern's side, mm.
        size_mm: f64,
        /// Length of one part, mm.
        part_mm: f64,
        /// Parts along the side.
        count: f64,
        /// Largest number of them.
        most: usize,
    },
    /// A picture that is too large for most programs.
    #[error("a picture of {width}x{height} px, {px_per_m} px per m, is too large")]
    TooManyPixels {
        /// Columns, px.
        width: f64,
        /// Rows, px.
        height: f64,
        /// Resolution.
        px_per_m: u32,
    },
    /// A sheet of paper that is too small.
    #[error("a pattern of {}x{} mm does not fit on {paper}", pattern_mm[0], pattern_mm[1])]
    Paper {
        /// The paper's name.
        paper: String,
        /// Width and height of the pattern, mm.
        pattern_mm: [f64; 2],
        /// Largest width and height of a pattern on the sheet in portrait and in landscape, mm.
        room_mm: [[f64; 2]; 2],
    },
    /// The camera's image shows no gel.
    #[error("the camera does not see the gel")]
    NotSeen,
    /// The colours cannot be drawn.
    #[error(transparent)]
    Colours(#[from] GelError),
}

impl PatternError {
    /// What to do about it.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::OutOfRange { allowed, .. } => format!("give {allowed}"),
            Self::DotsOverlap { pitch_mm, .. } => {
                format!("give a diameter below {pitch_mm:.4} mm, half of that is usual, or fewer dots")
            }
            Self::Count { count, .. } if *count < 3.0 => "give a larger pattern or smaller parts".into(),
            Self::Count { .. } => "give a smaller pattern or larger parts".into(),
            Self::TooManyPixels { .. } => "give a lower resolution, or write PDF or SVG, which have none".into(),
            Self::Paper { room_mm: [[width, height], [lying_width, lying_height]], .. } => format!(
                "--size-mm of up to {width}x{height} mm fits in portrait, {lying_width}x{lying_height} mm in landscape; without --page \
                 the page is as large as needed"
            ),
            Self::NotSeen => {
                "check the camera's principal point and translation, and the image's and the gel's size".into()
            }
            Self::Colours(_) => "give levels that differ more".into(),
        }
    }
}

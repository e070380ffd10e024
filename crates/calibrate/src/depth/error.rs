use std::path::PathBuf;

use fingervision_touch::TrackError;

/// The table that the user writes beside the images.
pub(super) const DEPTH_FILE: &str = "depth.csv";

/// Why a depth law cannot be fitted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DepthFitError {
    /// The images of a press cannot be tracked with the profile.
    #[error("{press}: {source}")]
    Track {
        /// The press.
        press: String,
        /// The error.
        source: Box<TrackError>,
    },
    /// The profile was made for images of another size.
    #[error(
        "{press}: its images are {}x{} px, but the profile's camera has its principal point at ({}, {}) px",
        region.0, region.1, principal_point_px[0], principal_point_px[1]
    )]
    OtherSize {
        /// The press.
        press: String,
        /// Columns and rows of the region of interest, px.
        region: (usize, usize),
        /// Of the profile's camera, px.
        principal_point_px: [f64; 2],
    },
    /// The table of depths is missing.
    #[error("{}: there are no depths: neither {DEPTH_FILE} nor truth/force.csv exists", folder.display())]
    NoDepths {
        /// The press.
        folder: PathBuf,
    },
    /// The table of depths cannot be read.
    #[error("{}: {error}", file.display())]
    Unreadable {
        /// The table.
        file: PathBuf,
        /// The system's message.
        error: std::io::Error,
    },
    /// A row of the table of depths is not valid.
    #[error("{}, line {line}: {reason}", file.display())]
    Table {
        /// The table.
        file: PathBuf,
        /// Counted from 1.
        line: usize,
        /// What is wrong with it.
        reason: String,
    },
    /// There are more or fewer depths than images.
    #[error("{press}: {images} images, but {depths} depths")]
    Count {
        /// The press.
        press: String,
        /// Number of images, at least.
        images: u64,
        /// Number of depths.
        depths: u64,
    },
    /// The depth is the same in every frame.
    #[error("{press}: the depth is the same in every frame: {depth_mm} mm")]
    Constant {
        /// The press.
        press: String,
        /// The depth, mm.
        depth_mm: f64,
    },
    /// The first image shows a pressed gel.
    #[error("{press}: the gel is already pressed at the start{}", depth_mm.map_or(String::new(), |depth| format!(": {depth} mm in the first frame")))]
    PressedAtStart {
        /// The press.
        press: String,
        /// The first depth, mm, if that is the reason.
        depth_mm: Option<f64>,
    },
    /// A depth below zero.
    #[error("{press}: frame {frame} has a negative depth, {depth_mm} mm")]
    Negative {
        /// The press.
        press: String,
        /// Counted from 0.
        frame: usize,
        /// Its depth, mm.
        depth_mm: f64,
    },
    /// Deeper than the gel is thick.
    #[error("{press}: its largest depth is {depth_mm} mm, above {most_mm} mm, {limit}")]
    TooDeep {
        /// The press.
        press: String,
        /// The deepest depth, mm.
        depth_mm: f64,
        /// The limit, mm.
        most_mm: f64,
        /// The limit's meaning.
        limit: &'static str,
    },
    /// Too shallow to be measured.
    #[error("{press}: its largest depth is {depth_mm} mm: below {least_mm} mm no motion can be measured")]
    TooShallow {
        /// The press.
        press: String,
        /// The deepest depth, mm.
        depth_mm: f64,
        /// The least measurable depth, mm.
        least_mm: f64,
    },
    /// The images do not follow the depths.
    #[error("{press}: the motion in the images does not follow the depth: their correlation is {correlation:.2}")]
    Unordered {
        /// The press.
        press: String,
        /// Of motion and depth, dimensionless.
        correlation: f64,
    },
    /// A slope that no sensor has.
    #[error("the depth law is impossible: a slope of {slope_mm:.3} mm, expected about {expected_mm:.3} mm")]
    Impossible {
        /// Of the line through the origin, mm.
        slope_mm: f64,
        /// The slope by the camera's perspective, mm; without a camera the nearest slope that a sensor can have.
        expected_mm: f64,
        /// Ratio of both.
        factor: f64,
    },
    /// A law that does not reproduce the depths.
    #[error("no depth law fits the presses: the error is {error_mm:.3} mm for depths of up to {deepest_mm} mm")]
    Useless {
        /// On presses that were left out, mm; with a single press on its own frames.
        error_mm: f64,
        /// The deepest depth, mm.
        deepest_mm: f64,
    },
    /// Most frames do not match the first.
    #[error("{press}: {lost} of {frames} frames are lost: most of the image does not match the first")]
    Lost {
        /// The press.
        press: String,
        /// Frames without a value.
        lost: usize,
        /// All frames.
        frames: usize,
    },
    /// The density does not follow the depth.
    #[error("{press}: the density feature does not grow with the depth")]
    NoResponse {
        /// The press, or the set of presses.
        press: String,
    },
    /// A slope per position needs the camera.
    #[error("the profile has no [camera], which the perspective law needs")]
    NoCamera,
}

impl DepthFitError {
    /// What the user can do about it.
    #[must_use]
    pub fn hint(&self) -> Option<String> {
        Some(match self {
            Self::Track { source, .. } => return source.hint(),
            Self::OtherSize { .. } => {
                "use the profile of the camera that recorded the press, or correct image.region_of_interest".into()
            }
            Self::NoDepths { .. } => {
                format!("write {DEPTH_FILE} beside the images: a line \"frame,depth_mm\", then a row for every image, from 0")
            }
            Self::Unreadable { .. } => "check that the file can be read and is text in UTF-8".into(),
            Self::Table { .. } => {
                "the first line names the columns, frame and depth_mm; then follows a row for every image, with commas between the cells and decimal points, as in 1,0.25".into()
            }
            Self::Count { .. } => "write a row with the depth of every image, from the first image on".into(),
            Self::Constant { .. } => "record from the untouched gel to the deepest point, with the depth of every image".into(),
            Self::Negative { .. } => "depth is positive where the gel is pressed in: reverse the signs of the column depth_mm".into(),
            Self::TooDeep { .. } => {
                "depth_mm is in mm: divide the column by 1000 if it is in µm; if the depths are correct, correct [gel] and [camera] in the profile".into()
            }
            Self::TooShallow { .. } => "depth_mm is in mm: multiply the column by 1000 if it is in m, or press deeper".into(),
            Self::Unordered { .. } => {
                "number the images in the order in which they were taken, and give each row of depth.csv the depth of its own image".into()
            }
            Self::Impossible { factor, .. } if *factor > 1.0 => {
                "nothing was written; check that depth_mm is in mm and not in µm, and that the profile's [camera] is this sensor's".into()
            }
            Self::Impossible { .. } => {
                "nothing was written; check that depth_mm is in mm and not in cm or m, and that the profile's [camera] is this sensor's".into()
            }
            Self::Useless { .. } => {
                "nothing was written; check that every depth.csv belongs to its images, and that all presses are from this sensor".into()
            }
            Self::PressedAtStart { .. } => "begin the recording before the indenter touches the gel".into(),
            Self::Lost { .. } => "record again with less motion between images, steady light and a sharp pattern".into(),
            Self::NoResponse { .. } => {
                "check that the depths belong to these images and that the indenter touches the gel within the field of view".into()
            }
            Self::NoCamera => "calibrate the camera first, or use --method line or origin".into(),
        })
    }
}

//! The result of a check.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::camera::BoardError;
use crate::depth::DepthFitError;

/// The kinds of faults of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum What {
    /// An image cannot be read, or does not fit the profile.
    Unreadable,
    /// There are too few images, or not as many as depths.
    Count,
    /// Values at the top of their range, which contain no information.
    TooBright,
    /// Values at the bottom of their range, or hardly above the noise.
    TooDark,
    /// The light changes within the recording.
    Light,
    /// Texture is too weak to be tracked: out of focus, or pattern cells too small for the camera.
    Unsharp,
    /// All images are identical to the last bit, which does not happen with a camera; or all are the same as those of
    /// another recording.
    Copies,
    /// The whole image moves, though nothing should.
    Drift,
    /// A part of the image moves, though nothing should.
    Touched,
    /// The board moves too little from image to image.
    StepTooSmall,
    /// The board moves too far from image to image.
    StepTooLarge,
    /// The board's steps are not equal.
    UnevenSteps,
    /// The board moves in another direction than given.
    Direction,
    /// The board fills too little of the image.
    TooLittleSeen,
    /// The table of depths is missing or is not that of a press.
    Depths,
    /// The first image shows a pressed gel.
    PressedAtStart,
    /// The images show another gel, or come from another camera.
    OtherSensor,
    /// The images do not follow the depths.
    Order,
    /// The press hardly moves the pattern.
    MotionTooSmall,
    /// Frames that could not be tracked.
    Lost,
    /// The press reaches beyond the image.
    CutByBorder,
}

/// One fault: what was measured, what is required, and what to change.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fault {
    /// Its kind.
    pub what: What,
    /// The measured value, with its unit.
    pub measured: String,
    /// The allowed values.
    pub allowed: String,
    /// What to change before recording again.
    pub remedy: String,
}

/// The result of checking a recording. `Display` is a line of its figures.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct RecordingCheck {
    /// Number of images.
    pub images: usize,
    /// Mean grey level, 0 to 255.
    pub mean_level: f64,
    /// Largest part of the values of an image at the top of their range, 0 to 1.
    pub saturated: f64,
    /// Largest part of the values of an image at the bottom of their range, 0 to 1.
    pub black: f64,
    /// Predicted standard deviation of the flow, median over the pixels, of the worst image, px; absent where none was
    /// found.
    pub deviation_px: Option<f64>,
    /// Noise of the camera, standard deviation of a channel, grey levels; of a still recording only.
    pub noise_levels: Option<f64>,
    /// Motion of the pattern, px: the drift of a still recording, the usual step of a board, the largest motion of a
    /// press.
    pub motion_px: Option<f64>,
    /// The fault; none: the recording can be used.
    pub faults: Vec<Fault>,
}

impl Fault {
    /// A fault of this kind: what was measured, what is allowed, what to do.
    #[must_use]
    pub fn new(what: What, measured: impl Into<String>, allowed: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { what, measured: measured.into(), allowed: allowed.into(), remedy: remedy.into() }
    }

    /// A recording that cannot be read, with the reader's message.
    #[must_use]
    pub fn unreadable(error: &impl fmt::Display, hint: Option<String>) -> Self {
        let remedy = hint.unwrap_or_else(|| "record it again".into());
        Self::new(What::Unreadable, error.to_string(), "images of one size that can be read", remedy)
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; required: {}", self.measured, self.allowed)
    }
}

impl RecordingCheck {
    /// Whether nothing is wrong.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.faults.is_empty()
    }

    /// A recording of which only the fault is known.
    #[must_use]
    pub fn refused(fault: Fault) -> Self {
        Self { faults: vec![fault], ..Self::default() }
    }
}

impl fmt::Display for RecordingCheck {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} images", self.images)?;
        if self.images > 0 {
            write!(f, ", mean level {:.0}", self.mean_level)?;
        }
        if let Some(noise) = self.noise_levels {
            write!(f, ", noise {noise:.1} levels")?;
        }
        if let Some(deviation) = self.deviation_px {
            write!(f, ", flow accurate to {deviation:.3} px")?;
        }
        if let Some(motion) = self.motion_px {
            let digits = if motion < 1.0 { 3 } else { 1 };
            write!(f, ", moves {motion:.digits$} px")?;
        }
        Ok(())
    }
}

impl From<&BoardError> for Fault {
    fn from(error: &BoardError) -> Self {
        let (what, allowed) = match error {
            BoardError::TooFewImages { .. } => (What::Count, "21 images"),
            BoardError::NoTexture { .. } => (What::Unsharp, "texture all over the board"),
            BoardError::NoMatch { .. } => (What::StepTooLarge, "consecutive images that show much of the same board"),
            BoardError::Still { .. } => (What::StepTooSmall, "3 to 30 px a step"),
            BoardError::UnevenStep { .. } => (What::UnevenSteps, "the same step between any two images"),
            BoardError::WrongDirection { .. } | BoardError::WrongStep { .. } => {
                (What::Direction, "the slide that was given")
            }
            BoardError::TooLittleSeen { .. } => (What::TooLittleSeen, "a board that fills the image"),
            BoardError::NotConverged { .. }
            | BoardError::Impossible { .. }
            | BoardError::Useless { .. }
            | BoardError::NotDetermined { .. }
            | BoardError::Flow(_)
            | BoardError::Image(_) => {
                return Self::unreadable(error, error.hint());
            }
        };
        Self::new(what, error.to_string(), allowed, error.hint().unwrap_or_default())
    }
}

impl From<&DepthFitError> for Fault {
    fn from(error: &DepthFitError) -> Self {
        let (what, measured, allowed) = match error {
            DepthFitError::NoDepths { .. } => (What::Depths, "it has no depth.csv".into(), "the depth of every image"),
            DepthFitError::Table { .. } | DepthFitError::Unreadable { .. } => {
                (What::Depths, error.to_string(), "a row with a depth for every image")
            }
            DepthFitError::Constant { depth_mm, .. } => {
                (What::Depths, format!("its depth is {depth_mm} mm in every row"), "depths from 0 to the deepest")
            }
            DepthFitError::Count { images, depths, .. } => {
                (What::Count, format!("{images} images, but {depths} depths"), "a depth for every image")
            }
            DepthFitError::Negative { frame, depth_mm, .. } => {
                (What::Depths, format!("frame {frame} is {depth_mm} mm deep"), "depths of 0 mm and more")
            }
            DepthFitError::TooDeep { depth_mm, .. } => (
                What::Depths,
                format!("its largest depth is {depth_mm} mm"),
                "depths in mm, less than the gel is thick",
            ),
            DepthFitError::TooShallow { depth_mm, .. } => {
                (What::Depths, format!("its largest depth is {depth_mm} mm"), "depths in mm that move the gel")
            }
            DepthFitError::PressedAtStart { depth_mm: Some(depth), .. } => (
                What::PressedAtStart,
                format!("the first image is {depth} mm deep"),
                "an untouched gel in the first image",
            ),
            _ => return Self::unreadable(error, error.hint()),
        };
        Self::new(what, measured, allowed, error.hint().unwrap_or_default())
    }
}

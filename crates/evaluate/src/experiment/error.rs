use fingervision_calibrate::camera::BoardError;
use fingervision_calibrate::depth::DepthFitError;
use fingervision_gel::SceneError;
use fingervision_optics::CameraError;
use fingervision_sink::SinkError;
use fingervision_touch::{ParameterError, ProfileError, TrackError};

use crate::dots::DotError;
use crate::run::RunError;

/// Why an experiment ended early.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExperimentError {
    /// The scene is impossible, or cannot be solved or drawn.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A press was not solved to its end.
    #[error("{scene}: {reason}")]
    EndedEarly {
        /// The scene.
        scene: String,
        /// Why it was not, and how far it got.
        reason: String,
    },
    /// The camera is impossible.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// A frame cannot be tracked.
    #[error(transparent)]
    Track(#[from] TrackError),
    /// A value cannot be set in the profile.
    #[error(transparent)]
    Profile(#[from] ProfileError),
    /// A parameter is out of range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The dots cannot be followed.
    #[error(transparent)]
    Dots(#[from] DotError),
    /// No depth law can be fitted.
    #[error(transparent)]
    Fit(#[from] DepthFitError),
    /// No camera can be fitted.
    #[error(transparent)]
    Board(#[from] BoardError),
    /// A run of another program cannot be used.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A picture or a file cannot be written.
    #[error(transparent)]
    Sink(#[from] SinkError),
    /// The caller interrupted it.
    #[error("interrupted")]
    Interrupted,
}

impl ExperimentError {
    /// What the user can do about it, if anything.
    #[must_use]
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::Scene(error) => error.hint(),
            Self::Profile(error) => error.hint(),
            Self::Fit(error) => error.hint(),
            Self::Board(error) => error.hint(),
            Self::Run(error) => error.hint(),
            Self::EndedEarly { .. } => Some("a coarser motion or a finer mesh may converge".into()),
            Self::Track(error) => error.hint(),
            Self::Sink(error) => error.hint().map(Into::into),
            Self::Parameter(error) => Some(format!("set {} to {}", error.key, error.allowed)),
            Self::Camera(_) | Self::Dots(_) | Self::Interrupted => None,
        }
    }
}

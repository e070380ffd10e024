//! Errors of a command, as shown to the user.

use std::fmt;
use std::io::{self, ErrorKind, Write};

use fingervision_calibrate::ProfileFileError;
use fingervision_calibrate::camera::BoardError;
use fingervision_calibrate::depth::DepthFitError;
use fingervision_calibrate::gel::GelFitError;
use fingervision_camera::CameraError;
use fingervision_evaluate::experiment::ExperimentError;
use fingervision_evaluate::run::RunError;
use fingervision_gel::{GelError, PatternError, SceneError};
use fingervision_image::ImageError;
use fingervision_page::PageError;
use fingervision_pipeline::PipelineError;
use fingervision_recording::RecordingError;
use fingervision_sink::SinkError;
use fingervision_source::SourceError;
use fingervision_touch::{ProfileError, TrackError};

use crate::interrupt;

/// Why a command ends early.
#[derive(Debug)]
pub(crate) enum Failure {
    /// Something went wrong.
    Stated {
        /// One line that names the thing and the value.
        message: String,
        /// What to do about it, if anything.
        hint: Option<String>,
    },
    /// The reader of the output has closed it.
    BrokenPipe,
}

impl Failure {
    pub(crate) fn new(message: impl Into<String>, hint: impl Into<String>) -> Self {
        Self::Stated { message: message.into(), hint: Some(hint.into()) }
    }

    /// Writes the error and its hint: a line each, or one JSON object in a line. Returns the exit code.
    pub(crate) fn report(&self, wording: Wording, errors: &mut impl Write) -> u8 {
        let Self::Stated { message, hint } = self else { return 0 };
        let exit_code = interrupt::exit_code().unwrap_or(1);
        // If standard error cannot be written, nobody can be informed.
        let _ = wording.error(message, hint.as_deref(), exit_code, errors);
        exit_code
    }
}

/// The form of errors and notes on standard error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Wording {
    /// Lines for people.
    Text,
    /// One JSON object per line, for programs.
    Json,
}

impl Wording {
    /// An error, what to do about it and its exit code.
    pub(crate) fn error(
        self,
        message: &str,
        hint: Option<&str>,
        exit_code: u8,
        errors: &mut impl Write,
    ) -> io::Result<()> {
        let (error, hint) = (one_line(message), hint.map(one_line));
        if self == Self::Json {
            return writeln!(errors, "{}", serde_json::json!({ "error": error, "hint": hint, "exit_code": exit_code }));
        }
        writeln!(errors, "error: {error}")?;
        hint.map_or(Ok(()), |hint| writeln!(errors, "hint: {hint}"))
    }

    /// A note.
    pub(crate) fn note(self, text: &str, errors: &mut impl Write) -> io::Result<()> {
        match self {
            Self::Text => writeln!(errors, "note: {text}"),
            Self::Json => writeln!(errors, "{}", serde_json::json!({ "note": text })),
        }
    }
}

/// The error, without the hint.
impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stated { message, .. } => f.write_str(message),
            Self::BrokenPipe => f.write_str("the output was closed"),
        }
    }
}

/// A file name can contain a line break; an error stays one line.
fn one_line(text: &str) -> String {
    text.lines().collect::<Vec<_>>().join(" ")
}

impl From<SourceError> for Failure {
    fn from(error: SourceError) -> Self {
        Self::Stated { message: error.to_string(), hint: error.hint() }
    }
}

impl From<SinkError> for Failure {
    fn from(error: SinkError) -> Self {
        Self::Stated { message: error.to_string(), hint: error.hint().map(Into::into) }
    }
}

impl From<CameraError> for Failure {
    fn from(error: CameraError) -> Self {
        Self::Stated { message: error.to_string(), hint: Some(error.hint()) }
    }
}

impl From<PipelineError> for Failure {
    fn from(error: PipelineError) -> Self {
        Self::Stated { message: error.to_string(), hint: error.hint() }
    }
}

impl From<RecordingError> for Failure {
    fn from(error: RecordingError) -> Self {
        Self::Stated { message: error.to_string(), hint: Some(error.hint()) }
    }
}

impl From<PageError> for Failure {
    fn from(error: PageError) -> Self {
        Self::Stated { message: error.to_string(), hint: Some(error.hint().into()) }
    }
}

impl From<TrackError> for Failure {
    fn from(error: TrackError) -> Self {
        Self::Stated { message: error.to_string(), hint: error.hint() }
    }
}

impl From<ProfileError> for Failure {
    fn from(error: ProfileError) -> Self {
        Self::Stated { message: error.to_string(), hint: error.hint() }
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::Stated { message: error.to_string(), hint: error.hint() }
    }
}

impl From<RunError> for Failure {
    fn from(error: RunError) -> Self {
        Self::Stated { message: error.to_string(), hint: error.hint() }
    }
}

impl From<BoardError> for Failure {
    fn from(error: BoardError) -> Self {
        Self::Stated { message: error.to_string(), hint: error.hint() }
    }
}

impl From<ExperimentError> for Failure {
    fn from(error: ExperimentError) -> Self {
        Self::Stated { message: error.to_string(), hint: error.hint() }
    }
}

impl From<ProfileFileError> for Failure {
    fn from(error: ProfileFileError) -> Self {
        Self::Stated { message: error.to_string(), hint: error.hint() }
    }
}

impl From<DepthFitError> for Failure {
    fn from(error: DepthFitError) -> Self {
        Self::Stated { message: error.to_string(), hint: error.hint() }
    }
}

impl From<GelFitError> for Failure {
    fn from(error: GelFitError) -> Self {
        Self::Stated { message: error.to_string(), hint: error.hint() }
    }
}

impl From<GelError> for Failure {
    fn from(error: GelError) -> Self {
        Self::Stated { message: error.to_string(), hint: None }
    }
}

impl From<PatternError> for Failure {
    fn from(error: PatternError) -> Self {
        Self::Stated { message: error.to_string(), hint: Some(error.hint()) }
    }
}

impl From<ImageError> for Failure {
    fn from(error: ImageError) -> Self {
        Self::Stated { message: error.to_string(), hint: None }
    }
}

/// Only standard output is written directly.
impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        if error.kind() == ErrorKind::BrokenPipe {
            Self::BrokenPipe
        } else {
            let hint = "free some space at the output's destination, or use another one";
            Self::new(format!("cannot write the output: {error}"), hint)
        }
    }
}

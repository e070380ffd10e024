use std::path::Path;

use fingervision_elastic::PressError;
use fingervision_settings::{Place, SettingsError, nearest};

use super::ready_made;
use crate::{IndenterError, PatternError, RenderError};

/// Why a scene cannot be simulated.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The scene's file or a value in it.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Neither a file nor a ready-made scene.
    #[error("no scene {name}: it is neither a file nor a ready-made scene")]
    Unknown {
        /// The name that was given.
        name: String,
    },
    /// The indenter is impossible, or does not fit the gel.
    #[error("{place}{error}")]
    Indenter {
        /// The place in the scene.
        place: Place,
        /// The error.
        error: Box<IndenterError>,
    },
    /// The pattern cannot be made.
    #[error("pattern: {0}")]
    Pattern(#[from] PatternError),
    /// The surface cannot be rendered.
    #[error("render: {0}")]
    Render(#[from] RenderError),
    /// The press cannot be set up.
    #[error(transparent)]
    Press(#[from] PressError),
}

impl SceneError {
    /// What the user can do about it, if anything.
    #[must_use]
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::Settings(error) if error.is_not_found() => Some(list_hint()),
            Self::Settings(error) => error.hint(),
            Self::Unknown { name } => {
                let names: Vec<_> = ready_made::names().collect();
                let guess = nearest(name, &names);
                Some(guess.map_or_else(list_hint, |guess| format!("did you mean {guess}?")))
            }
            Self::Indenter { error, .. } => Some(error.hint()),
            Self::Pattern(error) => Some(error.hint()),
            Self::Render(_) | Self::Press(_) => None,
        }
    }

    /// The same error, with its line in the scene's text if it is found there.
    pub(super) fn in_text(self, text: &str) -> Self {
        match self {
            Self::Settings(error) => Self::Settings(error.in_text(text)),
            Self::Indenter { error, .. } => Self::Indenter { place: Place::of_key(text, &error.key()), error },
            other => other,
        }
    }

    /// The same error, with the file's name.
    pub(super) fn in_file(self, path: &Path) -> Self {
        match self {
            Self::Settings(error) => Self::Settings(error.in_file(path)),
            Self::Indenter { place, error } => {
                Self::Indenter { place: Place { file: Some(path.to_owned()), ..place }, error }
            }
            other => other,
        }
    }
}

impl From<IndenterError> for SceneError {
    fn from(error: IndenterError) -> Self {
        match error {
            IndenterError::Setting(error) => Self::Settings(error),
            error => Self::Indenter { place: Place::default(), error: Box::new(error) },
        }
    }
}

fn list_hint() -> String {
    "`fingervision simulate --list` names the ready-made scenes".into()
}

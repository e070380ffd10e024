use std::fmt::Debug;
use std::io;
use std::path::{Path, PathBuf};

use crate::line::line_of;
use crate::{Place, nearest};

/// An error in a document.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// The file cannot be read.
    #[error("cannot read the {noun} {}: {}", file.display(), why_unreadable(*kind))]
    Read {
        /// The kind of document.
        noun: &'static str,
        /// The file.
        file: PathBuf,
        /// The system's message.
        kind: io::ErrorKind,
    },
    /// The text is not TOML.
    #[error("{place}{message}")]
    Syntax {
        /// The kind of document.
        noun: &'static str,
        /// The place.
        place: Place,
        /// The parser's message.
        message: String,
    },
    /// An unknown key.
    #[error("{place}unknown key {key}")]
    UnknownKey {
        /// The kind of document.
        noun: &'static str,
        /// The place.
        place: Place,
        /// The key's path.
        key: String,
        /// The names known in its table.
        known: Vec<String>,
    },
    /// A value of the wrong type, or a table without a required key.
    #[error("{place}{key}: {message}")]
    WrongType {
        /// The place.
        place: Place,
        /// The path of the value or table.
        key: String,
        /// What was found and what was expected.
        message: String,
    },
    /// An impossible value.
    #[error("{place}{key} = {value} is impossible: it must be {allowed}")]
    OutOfRange {
        /// The place.
        place: Place,
        /// The path of the value.
        key: String,
        /// The value.
        value: String,
        /// The possible values, with their unit.
        allowed: String,
    },
}

impl SettingsError {
    /// An impossible value at an unknown place.
    pub fn out_of_range(key: impl Into<String>, value: impl Debug, allowed: impl Into<String>) -> Self {
        let (key, value, allowed) = (key.into(), format!("{value:?}"), allowed.into());
        Self::OutOfRange { place: Place::default(), key, value, allowed }
    }

    /// What the user can do about it, if anything.
    #[must_use]
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::Read { noun, kind, .. } => match kind {
                io::ErrorKind::IsADirectory => Some(format!("name the {noun}'s file")),
                io::ErrorKind::InvalidData => Some(format!("a {noun} is a TOML file: save it as text in UTF-8")),
                io::ErrorKind::PermissionDenied => Some("make the file readable".into()),
                _ => None,
            },
            Self::Syntax { noun, .. } => Some(format!("a {noun} is a TOML file: key = value, with texts in quotes")),
            Self::UnknownKey { noun, key, known, .. } => Some(near_match(noun, key, known)),
            Self::WrongType { message, .. } if message.starts_with("unknown variant") => {
                let mut names = message.split('`').skip(1).step_by(2);
                let name = names.next()?;
                let known: Vec<_> = names.collect();
                Some(
                    nearest(name, &known)
                        .map_or_else(|| format!("possible values: {}", known.join(", ")), did_you_mean),
                )
            }
            Self::WrongType { message, .. } if message.starts_with("missing") => {
                Some("give all keys of the table, or leave the table out".into())
            }
            Self::WrongType { .. } => Some("numbers without quotes, lists in brackets, texts in quotes".into()),
            Self::OutOfRange { allowed, .. } => Some(format!("give {allowed}")),
        }
    }

    /// The same error, with the file's name.
    #[must_use]
    pub fn in_file(mut self, path: &Path) -> Self {
        if let Some(place) = self.place_mut() {
            place.file = Some(path.to_owned());
        }
        self
    }

    /// The same error, with the line of the value in `text`, if it has no line yet.
    #[must_use]
    pub fn in_text(mut self, text: &str) -> Self {
        if let Self::OutOfRange { place: Place { line: line @ None, .. }, key, .. } = &mut self {
            *line = line_of(text, key);
        }
        self
    }

    /// The same error without a line, of a text that the user does not see.
    pub(crate) fn without_line(mut self) -> Self {
        if let Some(place) = self.place_mut() {
            place.line = None;
        }
        self
    }

    /// Whether the document's file is missing.
    #[must_use]
    pub fn is_not_found(&self) -> bool {
        matches!(self, Self::Read { kind: io::ErrorKind::NotFound, .. })
    }

    fn place_mut(&mut self) -> Option<&mut Place> {
        match self {
            Self::Syntax { place, .. }
            | Self::UnknownKey { place, .. }
            | Self::WrongType { place, .. }
            | Self::OutOfRange { place, .. } => Some(place),
            Self::Read { .. } => None,
        }
    }
}

fn why_unreadable(kind: io::ErrorKind) -> String {
    match kind {
        io::ErrorKind::NotFound => "no such file".into(),
        io::ErrorKind::InvalidData => "it is not UTF-8 text".into(),
        _ => kind.to_string(),
    }
}

/// Suggests the known name that is most similar to the last part of `key`, or all of them.
fn near_match(noun: &str, key: &str, known: &[String]) -> String {
    let (table, name) = key.rsplit_once('.').map_or(("", key), |(table, name)| (table, name));
    let joint = if table.is_empty() { "" } else { "." };
    match nearest(name, known) {
        Some(best) => did_you_mean(&format!("{table}{joint}{best}")),
        None if known.is_empty() => format!("{table} has no keys"),
        None if table.is_empty() => format!("a {noun} has the keys {}", known.join(", ")),
        None => format!("{table} has the keys {}", known.join(", ")),
    }
}

fn did_you_mean(name: &str) -> String {
    format!("did you mean {name}?")
}

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use fingervision_flow::FlowError;
use fingervision_image::Rect;

use crate::ParameterError;

/// Names this alike, by [`strsim::jaro_winkler`], are worth suggesting, dimensionless.
const ALIKE: f64 = 0.8;

/// Where in a profile something is. Prints as a prefix such as `sensor.toml, line 7: `, empty if nothing is known.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Place {
    /// The profile's file; absent if it came from elsewhere.
    pub file: Option<PathBuf>,
    /// The line, from 1; absent for a value that was set by its path.
    pub line: Option<usize>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.file, self.line) {
            (Some(file), Some(line)) => write!(f, "{}, line {line}: ", file.display()),
            (Some(file), None) => write!(f, "{}: ", file.display()),
            (None, Some(line)) => write!(f, "line {line}: "),
            (None, None) => Ok(()),
        }
    }
}

/// What is wrong with a profile.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ProfileError {
    /// The file cannot be read.
    #[error("cannot read the profile {}: {}", file.display(), why_unreadable(*kind))]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system says.
        kind: io::ErrorKind,
    },
    /// The text is not TOML.
    #[error("{place}{message}")]
    Syntax {
        /// Where.
        place: Place,
        /// What the parser says.
        message: String,
    },
    /// A key that no profile has.
    #[error("{place}unknown key {key}")]
    UnknownKey {
        /// Where.
        place: Place,
        /// The key's path.
        key: String,
        /// The names that its table knows.
        known: Vec<String>,
    },
    /// A value of the wrong type, or a table without a key that it needs.
    #[error("{place}{key}: {message}")]
    WrongType {
        /// Where.
        place: Place,
        /// The path of the value or table.
        key: String,
        /// What was found and what was expected.
        message: String,
    },
    /// A value that no sensor has.
    #[error("{place}{key} = {value} is impossible: it takes {allowed}")]
    OutOfRange {
        /// Where.
        place: Place,
        /// The path of the value.
        key: String,
        /// The value.
        value: String,
        /// What is possible, with its unit.
        allowed: String,
    },
    /// The region of interest does not fit the frames.
    #[error(
        "image.region_of_interest = [{}, {}, {}, {}] reaches outside the frames of {}x{} px",
        region.x, region.y, region.width, region.height, frame_size.0, frame_size.1
    )]
    RegionOutside {
        /// The region, px.
        region: Rect,
        /// Columns and rows of the frames, px.
        frame_size: (usize, usize),
    },
}

impl ProfileError {
    /// What the user can do about it, where there is something to say.
    #[must_use]
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::Read { kind: io::ErrorKind::NotFound, .. } => {
                Some("leave --profile out to track an uncalibrated sensor".into())
            }
            Self::Read { .. } => None,
            Self::Syntax { .. } => Some("a profile is a TOML file: key = value, with texts in quotes".into()),
            Self::UnknownKey { key, known, .. } => Some(near_match(key, known)),
            Self::WrongType { message, .. } if message.starts_with("unknown variant") => {
                let mut names = message.split('`').skip(1).step_by(2);
                let name = names.next()?;
                let known: Vec<_> = names.collect();
                Some(nearest(name, &known).map_or_else(|| format!("it takes {}", known.join(", ")), did_you_mean))
            }
            Self::WrongType { message, .. } if message.starts_with("missing") => {
                Some("give all keys of the table, or leave the table out".into())
            }
            Self::WrongType { .. } => Some("numbers without quotes, lists in brackets, texts in quotes".into()),
            Self::OutOfRange { allowed, .. } => Some(format!("give {allowed}")),
            Self::RegionOutside { frame_size: (width, height), .. } => {
                Some(format!("the region is [x, y, width, height]; the whole frame is [0, 0, {width}, {height}]"))
            }
        }
    }

    /// The same error, in a file.
    pub(super) fn in_file(mut self, path: &Path) -> Self {
        match &mut self {
            Self::Syntax { place, .. }
            | Self::UnknownKey { place, .. }
            | Self::WrongType { place, .. }
            | Self::OutOfRange { place, .. } => place.file = Some(path.to_owned()),
            Self::Read { .. } | Self::RegionOutside { .. } => {}
        }
        self
    }
}

fn why_unreadable(kind: io::ErrorKind) -> String {
    match kind {
        io::ErrorKind::NotFound => "no such file".into(),
        io::ErrorKind::InvalidData => "it is not UTF-8 text".into(),
        _ => kind.to_string(),
    }
}

/// Suggests the known name that is most like the last part of `key`, or all of them.
fn near_match(key: &str, known: &[String]) -> String {
    let (table, name) = key.rsplit_once('.').map_or(("", key), |(table, name)| (table, name));
    let joint = if table.is_empty() { "" } else { "." };
    match nearest(name, known) {
        Some(best) => did_you_mean(&format!("{table}{joint}{best}")),
        None if known.is_empty() => format!("{table} takes no keys"),
        None if table.is_empty() => format!("a profile knows {}", known.join(", ")),
        None => format!("{table} knows {}", known.join(", ")),
    }
}

fn did_you_mean(name: &str) -> String {
    format!("did you mean {name}?")
}

/// The name that is most like `name`, if any is.
fn nearest<'a, S: AsRef<str>>(name: &str, known: &'a [S]) -> Option<&'a str> {
    let likeness = |known: &&str| strsim::jaro_winkler(name, known);
    let best = known.iter().map(AsRef::as_ref).max_by(|a, b| likeness(a).total_cmp(&likeness(b)))?;
    (likeness(&best) > ALIKE).then_some(best)
}

impl From<ParameterError> for ProfileError {
    fn from(error: ParameterError) -> Self {
        let (key, value, allowed) = (error.key.into(), error.value.to_string(), error.allowed.into());
        Self::OutOfRange { place: Place::default(), key, value, allowed }
    }
}

/// The key of what an error of the flow is about; a picture's size is the region's.
impl From<FlowError> for ProfileError {
    fn from(error: FlowError) -> Self {
        let place = Place::default();
        match error {
            FlowError::Parameter { name, value, range } => {
                let (key, value, allowed) = (format!("flow.{name}"), value.to_string(), range.into());
                Self::OutOfRange { place, key, value, allowed }
            }
            FlowError::TooSmall { width, height, least } => {
                let (key, value) = ("image.region_of_interest".into(), format!("{width}x{height} px"));
                Self::OutOfRange { place, key, value, allowed: format!("{least} px or more either way") }
            }
            FlowError::TooLarge { width, height, most } => {
                let (key, value) = ("image.region_of_interest".into(), format!("{width}x{height} px"));
                Self::OutOfRange { place, key, value, allowed: format!("{most} px or less in all") }
            }
        }
    }
}

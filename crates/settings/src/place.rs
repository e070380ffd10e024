use std::fmt;
use std::path::PathBuf;

use crate::line::line_of;

/// A place in a document. Prints as a prefix such as `sensor.toml, line 7: `, empty if nothing is known.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Place {
    /// The document's file; absent if it came from elsewhere.
    pub file: Option<PathBuf>,
    /// The line, from 1; absent for a value that was set by its path.
    pub line: Option<usize>,
}

impl Place {
    /// The place of the value at a path in a text, as in `motion.keyframes[2].depth_mm`. A value that is not in the text
    /// has the line of the innermost table on the way that is; without any, no line.
    #[must_use]
    pub fn of_key(text: &str, path: &str) -> Self {
        Self { file: None, line: line_of(text, path) }
    }
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

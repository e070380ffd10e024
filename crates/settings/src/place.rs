use std::fmt;
use std::path::PathBuf;

/// Where in a document something is. Prints as a prefix such as `sensor.toml, line 7: `, empty if nothing is known.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Place {
    /// The document's file; absent if it came from elsewhere.
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

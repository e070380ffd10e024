//! Whole numbers on the command line.

use std::str::FromStr;

/// Parses a number of frames, a frame's number or a seed.
pub(crate) fn whole_number<T: FromStr>(text: &str) -> Result<T, String> {
    text.parse().map_err(|_| "expected a whole number, 0 or more".into())
}

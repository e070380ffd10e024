//! The error for a parameter outside its range.

/// A parameter outside its range.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{key} = {value} is out of range: {allowed}")]
pub struct ParameterError {
    /// The parameter, by its name in its table of the profile.
    pub key: &'static str,
    /// Its value.
    pub value: f64,
    /// The allowed values, with their unit.
    pub allowed: &'static str,
}

impl ParameterError {
    /// Returns an error with this key, value and range unless the value is allowed.
    pub(crate) fn unless(
        is_allowed: bool,
        key: &'static str,
        value: impl Into<f64>,
        allowed: &'static str,
    ) -> Result<(), Self> {
        if is_allowed { Ok(()) } else { Err(Self { key, value: value.into(), allowed }) }
    }
}

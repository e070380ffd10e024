//! The environment variables that select the inputs.

use std::env;

/// The inputs of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Settings {
    pub(crate) seed: u64,
    /// The number of the first input.
    pub(crate) first: u64,
    /// How many inputs each parser gets.
    pub(crate) inputs: u64,
}

impl Settings {
    /// The settings from the environment; `inputs` if the environment does not set their number.
    ///
    /// # Panics
    ///
    /// If a variable is no number: a long run with a misspelt count must not pass for one.
    pub(crate) fn from_environment(inputs: u64) -> Self {
        Self {
            seed: number("FINGERVISION_FUZZ_SEED", 1),
            first: number("FINGERVISION_FUZZ_FIRST", 0),
            inputs: number("FINGERVISION_FUZZ_INPUTS", inputs),
        }
    }
}

fn number(variable: &str, default: u64) -> u64 {
    let Some(value) = env::var_os(variable) else { return default };
    let number = value.to_str().and_then(|value| value.parse().ok());
    number.unwrap_or_else(|| panic!("{variable} = {} is not a number", value.display()))
}

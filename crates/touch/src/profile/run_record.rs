//! The `run.toml` of a run, read as the profile that was in force.

use serde::Deserialize;

use super::{PROFILE, Profile};

/// What is read of a `run.toml`: its `[profile]`. The rest says how the run was made.
#[derive(Debug, Deserialize)]
pub(super) struct RunRecord {
    pub(super) profile: Profile,
}

/// What tells a `run.toml` from a profile, which has no such keys.
#[derive(Debug, Deserialize)]
struct Outline {
    #[expect(dead_code, reason = "it must be there")]
    version: String,
    #[expect(dead_code, reason = "it must be there")]
    profile: AnyTable,
}

/// A table, whatever it holds.
#[derive(Debug, Deserialize)]
struct AnyTable {}

/// Whether a text is that of a `run.toml`.
pub(super) fn is_run_record(text: &str) -> bool {
    PROFILE.parse::<Outline>(text).is_ok()
}

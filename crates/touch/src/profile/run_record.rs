//! The `run.toml` of a run, read as the profile that was in force.

use serde::Deserialize;

use super::{PROFILE, Profile};

/// The part of a `run.toml` that is read: its `[profile]`. The rest describes how the run was made.
#[derive(Debug, Deserialize)]
pub(super) struct RunRecord {
    pub(super) profile: Profile,
}

/// The keys that distinguish a `run.toml` from a profile.
#[derive(Debug, Deserialize)]
struct Outline {
    #[expect(dead_code, reason = "it must be there")]
    version: String,
    #[expect(dead_code, reason = "it must be there")]
    profile: AnyTable,
}

/// A table with any content.
#[derive(Debug, Deserialize)]
struct AnyTable {}

/// Whether a text is that of a `run.toml`.
pub(super) fn is_run_record(text: &str) -> bool {
    PROFILE.parse::<Outline>(text).is_ok()
}

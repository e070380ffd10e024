//! `run.toml`: how a run was made.

use fingervision_sink::Field;
use fingervision_touch::Profile;
use serde::Serialize;

use crate::failure::Failure;

#[derive(Debug, Serialize)]
struct RunRecord<'a> {
    version: &'a str,
    source: &'a str,
    fields: Vec<&'a str>,
    profile: &'a Profile,
}

/// The text of `run.toml`: version, source, fields and the whole profile in force.
pub(crate) fn run_record(source: &str, fields: &[Field], profile: &Profile) -> Result<String, Failure> {
    let fields = fields.iter().map(|field| field.name()).collect();
    let record = RunRecord { version: env!("CARGO_PKG_VERSION"), source, fields, profile };
    toml::to_string(&record)
        .map_err(|error| Failure::Stated { message: format!("the profile cannot be written: {error}"), hint: None })
}

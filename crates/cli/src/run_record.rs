//! Writes `run.toml`, the record of a run: version, source and all parameters.

use fingervision_sink::Field;
use fingervision_touch::{Profile, TractionGrid};
use serde::Serialize;

use crate::failure::Failure;
use crate::part::Part;

#[derive(Debug, Serialize)]
struct RunRecord<'a> {
    version: &'a str,
    source: &'a str,
    fields: Vec<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    part: Option<Part>,
    #[serde(skip_serializing_if = "Option::is_none")]
    traction: Option<TractionRecord>,
    profile: &'a Profile,
}

/// The grid of `traction.npy`, centred on the surface.
#[derive(Debug, Serialize)]
struct TractionRecord {
    columns: usize,
    rows: usize,
    cell_mm: f64,
}

/// The text of `run.toml`: version, source, fields, the part of the recording if it is not the whole, the grid of
/// tractions if there is one, and the complete profile in force.
pub(crate) fn run_record(
    source: &str,
    fields: &[Field],
    profile: &Profile,
    traction: Option<&TractionGrid>,
    part: Part,
) -> Result<String, Failure> {
    let fields = fields.iter().map(|field| field.name()).collect();
    let traction =
        traction.map(|&TractionGrid { columns, rows, cell_mm, .. }| TractionRecord { columns, rows, cell_mm });
    let part = (!part.is_whole()).then_some(part);
    let record = RunRecord { version: env!("CARGO_PKG_VERSION"), source, fields, part, traction, profile };
    toml::to_string(&record)
        .map_err(|error| Failure::Stated { message: format!("the profile cannot be written: {error}"), hint: None })
}

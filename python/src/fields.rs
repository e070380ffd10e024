//! The names of fields.

use fingervision_sink::Field;
use fingervision_touch::{DepthMethod, Profile, Reading};
use pyo3::prelude::*;

use crate::error::{exception, wrong_type, wrong_value};

/// The requested fields; absent: all that the profile is calibrated for.
pub(crate) fn requested(fields: Option<&Bound<'_, PyAny>>) -> PyResult<Option<Vec<Field>>> {
    let Some(fields) = fields else { return Ok(None) };
    let hint = "give a list or tuple of names, as in fields=[\"depth\"]";
    if fields.extract::<String>().is_ok() {
        return Err(wrong_type(format!("fields is the str {fields}"), hint));
    }
    let names: Vec<String> =
        fields.extract().map_err(|_| wrong_type(format!("fields is of type {}", fields.get_type()), hint))?;
    names.iter().map(|name| field(name)).collect::<PyResult<_>>().map(Some)
}

fn field(name: &str) -> PyResult<Field> {
    Field::ALL.into_iter().find(|field| field.name() == name).ok_or_else(|| {
        let known: Vec<&str> = Field::ALL.iter().map(|field| field.name()).collect();
        wrong_value(format!("there is no field {name:?}"), &format!("fields are {}", known.join(", ")))
    })
}

/// Checks that the readings of a tracker have the requested fields.
pub(crate) fn expect_all(requested: Option<&[Field]>, reading: &Reading, profile: &Profile) -> PyResult<()> {
    let absent = requested.into_iter().flatten().find(|field| !field.is_in(reading));
    absent.map_or(Ok(()), |field| Err(absence(*field, profile)))
}

/// Why a reading lacks a field.
pub(crate) fn absence(field: Field, profile: &Profile) -> PyErr {
    let (name, sensor) = (field.name(), &profile.name);
    let hint = match (field, profile.depth_method()) {
        (Field::Density, DepthMethod::Elastic) => "request it: fields=[\"density\"]",
        (Field::Depth, DepthMethod::Density) => {
            "give the profile [camera] and [gel], or fit depth.density by calibrate_depth"
        }
        (_, DepthMethod::Density) => "it needs elastic depth: give the profile [camera] and [gel]",
        (Field::Displacement, _) => "request it: fields=[\"depth\", \"displacement\"]",
        (Field::Traction, _) => {
            "request it: fields=[\"depth\", \"traction\"]; the profile needs gel.youngs_modulus_mpa"
        }
        _ => "request depth: leave fields out, or fields=[\"depth\"]",
    };
    exception("FieldError", &format!("there is no {name} in readings of the sensor {sensor:?}"), Some(hint))
}

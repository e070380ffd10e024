//! Values set by their path, as in `{"flow.finest_level": 1}`.

use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};

use crate::error::wrong_type;

/// Paths and values as the text of a settings file.
pub(crate) fn assignments(set: Option<&Bound<'_, PyDict>>) -> PyResult<Vec<(String, String)>> {
    let Some(set) = set else { return Ok(Vec::new()) };
    let pair = |(key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let key: String = key.extract().map_err(|_| {
            wrong_type(format!("a key of set is {key}"), "name the value by its path, as in \"flow.finest_level\"")
        })?;
        let value = text(&value).map_err(|error| named(&key, &error))?;
        Ok((key, value))
    };
    set.iter().map(pair).collect()
}

/// Pairs as the libraries take them.
pub(crate) fn pairs(assignments: &[(String, String)]) -> impl Iterator<Item = (&str, &str)> {
    assignments.iter().map(|(key, value)| (key.as_str(), value.as_str()))
}

fn named(key: &str, name: &str) -> PyErr {
    wrong_type(
        format!("set[{key:?}] is of type {name}"),
        "a value is a bool, an int, a float, a str, or a list or tuple of these",
    )
}

/// A value as TOML; the error is the name of a type that has no such form.
fn text(value: &Bound<'_, PyAny>) -> Result<String, String> {
    let type_name = || value.get_type().name().map_or_else(|_| "?".into(), |name| name.to_string());
    if let Ok(flag) = value.cast::<PyBool>() {
        return Ok(if flag.is_true() { "true" } else { "false" }.into());
    }
    if value.is_instance_of::<PyString>() || value.is_instance_of::<PyInt>() {
        return Ok(value.to_string());
    }
    if value.is_instance_of::<PyFloat>() {
        return value.extract::<f64>().map(|number| format!("{number:?}")).map_err(|_| type_name());
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let items = value.try_iter().map_err(|_| type_name())?;
        let items: Result<Vec<String>, String> =
            items.map(|item| item.map_err(|_| type_name()).and_then(|item| quoted(&item))).collect();
        return Ok(format!("[{}]", items?.join(", ")));
    }
    // A number of NumPy.
    match value.call_method0("item") {
        Ok(number) if !number.is(value) && number.get_type().name().is_ok_and(|name| name != "ndarray") => {
            text(&number)
        }
        _ => Err(type_name()),
    }
}

/// A value inside a list, where a string needs quotes.
fn quoted(value: &Bound<'_, PyAny>) -> Result<String, String> {
    if value.is_instance_of::<PyString>() { Ok(format!("{:?}", value.to_string())) } else { text(value) }
}

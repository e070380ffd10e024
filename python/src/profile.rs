//! Profiles.

use std::path::PathBuf;

use fingervision_sink::write_file;
use fingervision_touch::Profile;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple, PyType};

use crate::error::{OrRaise, exception, wrong_type};
use crate::settings::{assignments, pairs};

/// One sensor: its camera, its gel, its calibration and the parameters of tracking. Cannot be changed.
///
/// `Profile()` is a sensor without calibration, tracked over the whole image, without depth. `Profile.load(path)` reads a
/// file, `profile.replace({"flow.finest_level": 1})` is a copy with other values. Profiles can be compared and pickled.
#[pyclass(frozen, eq, name = "Profile", module = "fingervision")]
#[derive(PartialEq)]
pub(crate) struct PyProfile {
    pub(crate) profile: Profile,
}

#[pymethods]
impl PyProfile {
    #[new]
    #[pyo3(signature = (*, set=None))]
    fn new(set: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        with(Profile::default(), set)
    }

    /// The profile in a file: `sensor.toml`, or the `run.toml` of a run.
    ///
    /// Raises `ProfileError` with the line that is wrong.
    #[classmethod]
    #[pyo3(signature = (path, *, set=None))]
    fn load(_class: &Bound<'_, PyType>, path: PathBuf, set: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        with(Profile::load(&path).or_raise()?, set)
    }

    /// The profile in a text, as of its file.
    ///
    /// Raises `ProfileError` with the line that is wrong.
    #[classmethod]
    fn from_toml(_class: &Bound<'_, PyType>, text: &str) -> PyResult<Self> {
        with(Profile::from_toml(text).or_raise()?, None)
    }

    /// A copy with some values set by their paths, as in `{"gel.thickness_mm": 8.0}`.
    ///
    /// Raises `ProfileError` for a path that does not exist or a value that is impossible.
    fn replace(&self, set: &Bound<'_, PyDict>) -> PyResult<Self> {
        with(self.profile.clone(), Some(set))
    }

    /// The text of its file, every default written out.
    fn to_toml(&self) -> String {
        self.profile.to_toml()
    }

    /// Writes its file, as a whole or not at all.
    ///
    /// Raises `SourceError` if the file cannot be written.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        write_file(&path, self.profile.to_toml().as_bytes())
            .map_err(|error| exception("SourceError", &error.to_string(), error.hint()))
    }

    /// The name of the sensor.
    #[getter]
    fn name(&self) -> &str {
        &self.profile.name
    }

    /// How depth is computed: `"elastic"` or `"density"`.
    #[getter]
    fn depth_method(&self) -> &'static str {
        self.profile.depth_method().name()
    }

    fn __repr__(&self) -> String {
        format!("Profile(name={:?}, depth_method={:?})", self.profile.name, self.profile.depth_method().name())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let make = py.get_type::<Self>().getattr("from_toml")?;
        Ok((make, PyTuple::new(py, [self.to_toml()])?))
    }
}

fn with(mut profile: Profile, set: Option<&Bound<'_, PyDict>>) -> PyResult<PyProfile> {
    profile.set_all(pairs(&assignments(set)?)).or_raise()?;
    Ok(PyProfile { profile })
}

/// The profile of an argument: a `Profile`, a path, or nothing.
pub(crate) fn given(profile: Option<&Bound<'_, PyAny>>) -> PyResult<Option<Profile>> {
    let Some(profile) = profile else { return Ok(None) };
    if let Ok(profile) = profile.cast::<PyProfile>() {
        return Ok(Some(profile.get().profile.clone()));
    }
    let Ok(path) = profile.extract::<PathBuf>() else {
        let name = profile.get_type().name()?;
        return Err(wrong_type(format!("profile is of type {name}"), "give a Profile or the path of its file"));
    };
    Profile::load(&path).or_raise().map(Some)
}

/// The profile in force: the given one or the fallback, with values set.
pub(crate) fn in_force(
    given: Option<Profile>,
    fallback: impl FnOnce() -> PyResult<Profile>,
    set: &[(String, String)],
) -> PyResult<Profile> {
    let mut profile = given.map_or_else(fallback, Ok)?;
    profile.set_all(pairs(set)).or_raise()?;
    Ok(profile)
}

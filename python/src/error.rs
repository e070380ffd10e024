//! Errors: those of the libraries become the exceptions of `fingervision._errors`, with the same message and hint.

use std::fmt::Display;

use fingervision_camera::CameraError;
use fingervision_flow::FlowError;
use fingervision_gel::SceneError;
use fingervision_image::ImageError;
use fingervision_recording::RecordingError;
use fingervision_source::SourceError;
use fingervision_touch::{ProfileError, TrackError};
use pyo3::prelude::*;

/// An exception by the name of its class in `fingervision._errors`.
pub(crate) fn exception(class: &str, message: &str, hint: Option<&str>) -> PyErr {
    Python::attach(|py| {
        let made = || {
            let error = py.import("fingervision._errors")?.getattr(class)?.call1((message,))?;
            error.setattr("hint", hint)?;
            PyResult::Ok(PyErr::from_value(error))
        };
        made().unwrap_or_else(|error| error)
    })
}

/// An argument of the right type with a value that cannot be used.
pub(crate) fn wrong_value(message: impl Display, hint: &str) -> PyErr {
    exception("ArgumentError", &message.to_string(), Some(hint))
}

/// An argument of a wrong type.
pub(crate) fn wrong_type(message: impl Display, hint: &str) -> PyErr {
    exception("ArgumentTypeError", &message.to_string(), Some(hint))
}

/// An error of a library that has a class of its own in Python.
pub(crate) trait Fault {
    fn raised(self) -> PyErr;
}

/// The result, with its error as an exception.
pub(crate) trait OrRaise<T> {
    fn or_raise(self) -> PyResult<T>;
}

impl<T, E: Fault> OrRaise<T> for Result<T, E> {
    fn or_raise(self) -> PyResult<T> {
        self.map_err(Fault::raised)
    }
}

impl Fault for SourceError {
    fn raised(self) -> PyErr {
        let class = if matches!(self, Self::NotFound { .. }) { "NotFoundError" } else { "SourceError" };
        exception(class, &self.to_string(), self.hint().as_deref())
    }
}

impl Fault for ProfileError {
    fn raised(self) -> PyErr {
        exception("ProfileError", &self.to_string(), self.hint().as_deref())
    }
}

impl Fault for TrackError {
    fn raised(self) -> PyErr {
        exception("TrackError", &self.to_string(), self.hint().as_deref())
    }
}

impl Fault for SceneError {
    fn raised(self) -> PyErr {
        exception("SceneError", &self.to_string(), self.hint().as_deref())
    }
}

impl Fault for RecordingError {
    fn raised(self) -> PyErr {
        exception("RecordingError", &self.to_string(), Some(&self.hint()))
    }
}

impl Fault for CameraError {
    fn raised(self) -> PyErr {
        exception("CameraError", &self.to_string(), Some(&self.hint()))
    }
}

impl Fault for FlowError {
    fn raised(self) -> PyErr {
        exception("FlowError", &self.to_string(), None)
    }
}

impl Fault for ImageError {
    fn raised(self) -> PyErr {
        exception("ArgumentError", &self.to_string(), None)
    }
}

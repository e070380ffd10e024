//! `open`: the readings of a source, one after another.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

use fingervision_camera::CameraSource;
use fingervision_cli::Place;
use fingervision_gel::PressCache;
use fingervision_recording::{Recording, RecordingSource};
use fingervision_simulation::simulated_profile;
use fingervision_sink::Field;
use fingervision_source::{Options, Source};
use fingervision_touch::Profile;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::{OrRaise, exception, wrong_value};
use crate::fields;
use crate::profile::{PyProfile, given, in_force};
use crate::reading::PyReading;
use crate::settings::assignments;
use crate::tracking::Tracking;

/// The readings of a source, from `fingervision.open`: an iterator, and a context manager that closes the source.
///
/// After an error the source is at its end: the next call ends the iteration.
#[pyclass(frozen, name = "Readings", module = "fingervision")]
pub(crate) struct PyReadings {
    state: Mutex<State>,
    profile: Profile,
    size: (usize, usize),
    description: String,
    remarks: Vec<String>,
    frame_count: Option<u64>,
}

struct State {
    /// Absent if it is closed.
    source: Option<Box<dyn Source>>,
    tracking: Tracking,
}

impl PyReadings {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn next(&mut self) -> PyResult<Option<PyReading>> {
        let Some(source) = &mut self.source else {
            let hint = "read inside the with block, or open it again";
            return Err(exception("ClosedError", "the source is closed", Some(hint)));
        };
        let frame = source.next_frame().or_raise()?;
        frame.map(|frame| self.tracking.track(frame, None)).transpose()
    }
}

#[pymethods]
impl PyReadings {
    fn __iter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<PyReading>> {
        py.check_signals()?;
        py.detach(|| self.lock().next())
    }

    fn __enter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    #[pyo3(signature = (*_arguments))]
    fn __exit__(&self, py: Python<'_>, _arguments: &Bound<'_, PyAny>) {
        self.close(py);
    }

    /// Closes the source. Reading on raises `ClosedError`, which is a `ValueError`.
    fn close(&self, py: Python<'_>) {
        py.detach(|| self.lock().source = None);
    }

    /// Makes the next frame the new reference: from there on displacement, depth and force are relative to it.
    fn reset(&self, py: Python<'_>) {
        py.detach(|| self.lock().tracking.rezero());
    }

    /// The profile in force.
    #[getter]
    fn profile(&self) -> PyProfile {
        PyProfile { profile: self.profile.clone() }
    }

    /// Rows and columns of the fields, px: the region of interest.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        (self.size.1, self.size.0)
    }

    /// Number of frames; `None` where that is not known beforehand.
    #[getter]
    fn frame_count(&self) -> Option<u64> {
        self.frame_count
    }

    /// One line on where the frames come from and what they are.
    #[getter]
    fn description(&self) -> &str {
        &self.description
    }

    /// What is unusual about the source, a sentence each.
    #[getter]
    fn remarks(&self) -> Vec<String> {
        self.remarks.clone()
    }

    fn __repr__(&self) -> String {
        format!("Readings({:?})", self.description)
    }
}

/// Opens a source and tracks it: iterate over its readings. The first frame is the reference: it shows the gel untouched.
///
/// `source` is a folder of images, a video, a recording `FILE.mcap` (`FILE.mcap?sensor=NAME` if it has several), a
/// simulated press `sim:SCENE`, or a camera: `camera`, `camera:ID`, `/dev/video0`. `profile` is a `Profile` or the path
/// of its file; without it, a recording has its own, a simulated press that of its sensor, and any other source is tracked
/// without calibration. `fields` lists what is computed, as in `["depth", "displacement", "traction"]`; without it all
/// that the profile is calibrated for, except displacement and traction. `frames_per_second` is the rate of an image
/// folder or a simulated press, 30 by default. `set` sets values of the profile by their paths, as in
/// `{"flow.finest_level": 1}`.
///
/// The same frames give the same bits as in the command `fingervision track`. A simulated press is solved first, which may
/// take minutes (`sim:letter?draft`: seconds), and is then kept.
///
/// Raises `NotFoundError`, `SourceError`, `RecordingError`, `CameraError`, `ProfileError`, `FieldError`, `ArgumentError`.
#[pyfunction]
#[pyo3(signature = (source, profile=None, *, fields=None, frames_per_second=None, set=None))]
pub(crate) fn open(
    py: Python<'_>,
    source: PathBuf,
    profile: Option<&Bound<'_, PyAny>>,
    fields: Option<&Bound<'_, PyAny>>,
    frames_per_second: Option<f64>,
    set: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyReadings> {
    let requested = fields::requested(fields)?;
    let (given, set) = (given(profile)?, assignments(set)?);
    py.detach(|| tracked(opened(&source, frames_per_second, given, &set)?, requested))
}

/// A source, the profile in force, and whether its frames have colour, where that is known.
type Opened = (Profile, Box<dyn Source>, Option<bool>);

/// The readings of a source with the requested fields.
pub(crate) fn tracked(opened: Opened, requested: Option<Vec<Field>>) -> PyResult<PyReadings> {
    let (mut profile, source, first_is_colour) = opened;
    let (remarks, description, frame_count) = (source.remarks(), source.description(), source.frame_count());
    profile.flow.colour &= source.has_full_colour();
    let mut tracking = Tracking::new(profile.clone(), requested);
    let size = profile.region(source.size()).or_raise()?;
    if let Some(is_colour) = first_is_colour {
        tracking.begin(source.size(), is_colour)?;
    }
    let state = Mutex::new(State { source: Some(source), tracking });
    Ok(PyReadings { state, profile, size: (size.width, size.height), description, remarks, frame_count })
}

/// A sensor of a recording as a source.
pub(crate) fn opened_recording(
    recording: &Recording,
    sensor: Option<&str>,
    given: Option<Profile>,
    set: &[(String, String)],
) -> PyResult<Opened> {
    let sensor = recording.sensor(sensor).or_raise()?;
    let recorded = || Ok(recording.profile(sensor).or_raise()?.unwrap_or_default());
    let profile = in_force(given, recorded, set)?;
    Ok((profile, Box::new(RecordingSource::open(recording.clone(), sensor).or_raise()?), None))
}

fn opened(
    location: &std::path::Path,
    frames_per_second: Option<f64>,
    given: Option<Profile>,
    set: &[(String, String)],
) -> PyResult<Opened> {
    let options = frames_per_second.map_or_else(Options::default, |frames_per_second| Options { frames_per_second });
    options.validate().or_raise()?;
    let place = Place::of(location).or_raise()?;
    let has_times = match &place {
        Place::Simulated(press) => press.has_rate(),
        Place::File(path) => path.is_file(),
        _ => true,
    };
    if has_times && frames_per_second.is_some() {
        let message = format!("frames_per_second has no effect: {} has its own times", location.display());
        return Err(wrong_value(message, "leave frames_per_second out"));
    }
    let plain = || Ok(Profile::default());
    Ok(match place {
        Place::Simulated(press) => {
            let scene = press.scene().or_raise()?;
            let profile = in_force(given, || Ok(simulated_profile(&scene)), set)?;
            let mut interrupted = None;
            let mut progress = |_| go_on_unless_interrupted(&mut interrupted);
            let source = press.open(&options, &PressCache::standard(), &mut progress);
            if let Some(error) = interrupted {
                return Err(error);
            }
            (profile, source.or_raise()?, Some(scene.render.colour))
        }
        Place::Camera(id) => {
            let profile = in_force(given, plain, set)?;
            let camera = fingervision_camera::open(profile.capture_from(id.as_deref())).or_raise()?;
            (profile, Box::new(CameraSource::new(camera)), None)
        }
        Place::Recording(path, sensor) => {
            opened_recording(&Recording::open(&path).or_raise()?, sensor.as_deref(), given, set)?
        }
        Place::File(path) => {
            let profile = in_force(given, plain, set)?;
            (profile, fingervision_simulation::open(path, &options).or_raise()?, None)
        }
        _ => return Err(wrong_value(format!("{} cannot be opened", location.display()), "see fingervision.open")),
    })
}

/// Ends a solution when the user presses Ctrl-C.
pub(crate) fn go_on_unless_interrupted(interrupted: &mut Option<PyErr>) -> ControlFlow<()> {
    #[expect(clippy::redundant_closure_for_method_calls, reason = "the method holds for one lifetime alone")]
    let checked = Python::attach(|py| py.check_signals());
    match checked {
        Ok(()) => ControlFlow::Continue(()),
        Err(error) => {
            *interrupted = Some(error);
            ControlFlow::Break(())
        }
    }
}

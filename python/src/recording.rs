//! Recordings: what is in an MCAP file, as arrays.

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use fingervision_recording::{RecordedTruth, Recording, RecordingSource};
use fingervision_source::Source;
use fingervision_touch::ReadingNumbers;
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::OrRaise;
use crate::profile::{PyProfile, given};
use crate::readings::{PyReadings, opened_recording, tracked};
use crate::settings::assignments;
use crate::{arrays, fields};

/// A recording in an MCAP file, as `fingervision record` writes it; opened, and read when asked.
///
/// `fingervision.open(path)` tracks it instead. A method's `sensor` is the name of one of `sensors`; it may be left out if
/// there is only one.
///
/// Raises `RecordingError` if the file is none.
#[pyclass(frozen, name = "Recording", module = "fingervision")]
pub(crate) struct PyRecording {
    recording: Recording,
}

/// A frame of a recording.
#[pyclass(frozen, get_all, name = "Frame", module = "fingervision")]
pub(crate) struct PyFrame {
    /// The frame's number, from 0; numbers of missing frames are skipped.
    sequence: u64,
    /// When it was exposed, s.
    capture_time_s: f64,
    /// The camera image: `(H, W)` or `(H, W, 3)` in red, green, blue; uint8 or uint16.
    image: Py<PyAny>,
}

/// The frames of a sensor of a recording, an iterator.
#[pyclass(frozen, name = "Frames", module = "fingervision")]
pub(crate) struct PyFrames {
    source: Mutex<RecordingSource>,
    count: u64,
}

impl PyRecording {
    fn index(&self, sensor: Option<&str>) -> PyResult<usize> {
        self.recording.sensor(sensor).or_raise()
    }
}

#[pymethods]
impl PyRecording {
    #[new]
    fn new(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        py.detach(|| Recording::open(&path)).or_raise().map(|recording| Self { recording })
    }

    /// The names of the sensors.
    #[getter]
    fn sensors(&self) -> Vec<String> {
        self.recording.sensors().iter().map(|sensor| sensor.name.clone()).collect()
    }

    /// What is unusual about the file, a sentence each: that it was not closed, or is damaged.
    #[getter]
    fn remarks(&self) -> Vec<String> {
        self.recording.remarks()
    }

    /// The profile that was in force; `None` if it is not in the file.
    #[pyo3(signature = (sensor=None))]
    fn profile(&self, sensor: Option<&str>) -> PyResult<Option<PyProfile>> {
        let profile = self.recording.profile(self.index(sensor)?).or_raise()?;
        Ok(profile.map(|profile| PyProfile { profile }))
    }

    /// The frames, decoded one by one.
    ///
    /// Raises `SourceError` while iterating if one is damaged.
    #[pyo3(signature = (sensor=None))]
    fn frames(&self, sensor: Option<&str>) -> PyResult<PyFrames> {
        let source = RecordingSource::open(self.recording.clone(), self.index(sensor)?).or_raise()?;
        let count = source.frame_count().unwrap_or_default();
        Ok(PyFrames { source: Mutex::new(source), count })
    }

    /// When each frame was exposed, `(N,)` float64, s, on the source's clock; quicker than `frames()`, which decodes images.
    #[pyo3(signature = (sensor=None))]
    fn capture_times_s<'py>(&self, py: Python<'py>, sensor: Option<&str>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let index = self.index(sensor)?;
        Ok(py.detach(|| self.recording.capture_times_s(index)).or_raise()?.into_pyarray(py))
    }

    /// Tracks the frames of a sensor, as `fingervision.open` does. `profile`, `fields` and `set` are those of `open`.
    ///
    /// Raises `RecordingError`, `SourceError`, `ProfileError`, `FieldError`, `ArgumentError`.
    #[pyo3(signature = (profile=None, *, sensor=None, fields=None, set=None))]
    fn track(
        &self,
        py: Python<'_>,
        profile: Option<&Bound<'_, PyAny>>,
        sensor: Option<&str>,
        fields: Option<&Bound<'_, PyAny>>,
        set: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyReadings> {
        let requested = fields::requested(fields)?;
        let (given, set) = (given(profile)?, assignments(set)?);
        py.detach(|| tracked(opened_recording(&self.recording, sensor, given, &set)?, requested))
    }

    /// The events, such as a lost camera or a re-zero, a sentence each.
    #[pyo3(signature = (sensor=None))]
    fn events(&self, sensor: Option<&str>) -> PyResult<Vec<String>> {
        self.recording.events(self.index(sensor)?).or_raise()
    }

    /// The numbers of the recorded readings, a column each, of length `N`.
    ///
    /// `sequence` and `dropped_frames`, int64; `capture_time_s` and `latency_ms`, float64; `photometric_error`,
    /// `mean_level`, `saturated_part`, `sharpness`, float32, as in a `Reading`; `max_depth_mm`, `contact_area_mm2`,
    /// `torque_nmm`, float32, and `force_n`, `(N, 3)` float32, N, with NaN where a reading has none; `flags`, a list of
    /// strings joined by `+`.
    #[pyo3(signature = (sensor=None))]
    fn readings<'py>(&self, py: Python<'py>, sensor: Option<&str>) -> PyResult<Bound<'py, PyDict>> {
        let index = self.index(sensor)?;
        let numbers = py.detach(|| self.recording.readings(index)).or_raise()?;
        let table = PyDict::new(py);
        let whole =
            |value: fn(&ReadingNumbers) -> u64| numbers.iter().map(|row| value(row).cast_signed()).collect::<Vec<_>>();
        let long = |value: fn(&ReadingNumbers) -> f64| numbers.iter().map(value).collect::<Vec<_>>();
        let short = |value: fn(&ReadingNumbers) -> Option<f32>| {
            numbers.iter().map(|row| value(row).unwrap_or(f32::NAN)).collect::<Vec<_>>()
        };
        table.set_item("sequence", whole(|row| row.sequence).into_pyarray(py))?;
        table.set_item("capture_time_s", long(|row| row.capture_time_s).into_pyarray(py))?;
        table.set_item("dropped_frames", whole(|row| row.dropped_frames).into_pyarray(py))?;
        table.set_item("photometric_error", short(|row| Some(row.photometric_error)).into_pyarray(py))?;
        table.set_item("mean_level", short(|row| Some(row.mean_level)).into_pyarray(py))?;
        table.set_item("saturated_part", short(|row| Some(row.saturated_part)).into_pyarray(py))?;
        table.set_item("sharpness", short(|row| Some(row.sharpness)).into_pyarray(py))?;
        table.set_item("latency_ms", long(|row| row.latency_ms).into_pyarray(py))?;
        table.set_item("max_depth_mm", short(|row| row.max_depth_mm).into_pyarray(py))?;
        table.set_item("contact_area_mm2", short(|row| row.contact_area_mm2).into_pyarray(py))?;
        let forces: Vec<[f32; 3]> = numbers.iter().map(|row| row.force_n.unwrap_or([f32::NAN; 3])).collect();
        table.set_item("force_n", arrays::rows(py, &forces)?)?;
        table.set_item("torque_nmm", short(|row| row.torque_nmm).into_pyarray(py))?;
        table.set_item("flags", numbers.iter().map(|row| row.flags.to_string()).collect::<Vec<_>>())?;
        Ok(table)
    }

    /// The truth of every frame of a simulated sensor, a column each, of length `N`, which is 0 for a real sensor.
    ///
    /// `sequence`, int64; `capture_time_s`, s, `depth_mm`, the indentation depth of the indenter, mm, and `torque_nmm`,
    /// N mm, float64; `force_n`, `(N, 3)` float64, N, pressing is +z.
    #[pyo3(signature = (sensor=None))]
    fn truths<'py>(&self, py: Python<'py>, sensor: Option<&str>) -> PyResult<Bound<'py, PyDict>> {
        let index = self.index(sensor)?;
        let truths = py.detach(|| self.recording.truths(index)).or_raise()?;
        let numbers = |value: fn(&RecordedTruth) -> f64| truths.iter().map(value).collect::<Vec<_>>();
        let sequences: Vec<i64> = truths.iter().map(|row| row.sequence.cast_signed()).collect();
        let forces: Vec<[f64; 3]> = truths.iter().map(|row| row.truth.force_n).collect();
        let table = PyDict::new(py);
        table.set_item("sequence", sequences.into_pyarray(py))?;
        table.set_item("capture_time_s", numbers(|row| row.capture_time_s).into_pyarray(py))?;
        table.set_item("depth_mm", numbers(|row| row.truth.depth_mm).into_pyarray(py))?;
        table.set_item("force_n", arrays::rows(py, &forces)?)?;
        table.set_item("torque_nmm", numbers(|row| row.truth.torque_nmm).into_pyarray(py))?;
        Ok(table)
    }

    fn __repr__(&self) -> String {
        format!("Recording({:?}, sensors={:?})", self.recording.path().display().to_string(), self.sensors())
    }
}

#[pymethods]
impl PyFrames {
    fn __iter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __len__(&self) -> usize {
        self.count as usize
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<PyFrame>> {
        py.check_signals()?;
        let next = || self.source.lock().unwrap_or_else(PoisonError::into_inner).next_frame();
        let Some(frame) = py.detach(next).or_raise()? else { return Ok(None) };
        let image = arrays::image(py, &frame.pixels)?;
        Ok(Some(PyFrame { sequence: frame.sequence, capture_time_s: frame.capture_time_s, image }))
    }
}

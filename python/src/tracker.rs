//! The tracker, for programs that have images of their own.

use std::sync::{Mutex, MutexGuard, PoisonError};

use fingervision_image::Frame;
use fingervision_touch::Profile;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::wrong_value;
use crate::fields;
use crate::pixels::{Channels, expect_same_format, pixels};
use crate::profile::{PyProfile, given, in_force};
use crate::reading::PyReading;
use crate::settings::assignments;
use crate::tracking::Tracking;

/// Tracks the gel through images that your program provides. The first image is the reference: it shows the gel untouched.
///
/// `profile` is a `Profile`, the path of its file, or `None` for a sensor without calibration: displacement and density
/// only. `fields` lists what is computed; without it all that the profile is calibrated for. `channels` is the order of
/// colour: `"rgb"`, or `"bgr"` for images that OpenCV has read; grey images need none. `frames_per_second` gives images without a time theirs.
/// `set` sets values of the profile by their paths, as in `{"flow.finest_level": 1}`.
///
/// While an image is tracked, other threads of Python run. Each thread should have a tracker of its own; calls of the same
/// tracker wait for each other.
///
/// Raises `ProfileError` and `ArgumentError`; what depends on the size of the images is checked with the first of them.
#[pyclass(frozen, name = "Tracker", module = "fingervision")]
pub(crate) struct PyTracker {
    state: Mutex<State>,
    channels: Option<Channels>,
    frames_per_second: f64,
}

struct State {
    tracking: Tracking,
    next_sequence: u64,
}

impl PyTracker {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl PyTracker {
    #[new]
    #[pyo3(signature = (profile=None, *, fields=None, channels=None, frames_per_second=30.0, set=None))]
    fn new(
        profile: Option<&Bound<'_, PyAny>>,
        fields: Option<&Bound<'_, PyAny>>,
        channels: Option<&str>,
        frames_per_second: f64,
        set: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let profile = in_force(given(profile)?, || Ok(Profile::default()), &assignments(set)?)?;
        if !(frames_per_second.is_finite() && frames_per_second > 0.0) {
            let message = format!("frames_per_second is {frames_per_second}");
            return Err(wrong_value(message, "a rate is a number above 0"));
        }
        let tracking = Tracking::new(profile, fields::requested(fields)?);
        let state = Mutex::new(State { tracking, next_sequence: 0 });
        Ok(Self { state, channels: channels.map(Channels::of).transpose()?, frames_per_second })
    }

    /// The reading of an image: `(H, W)` or `(H, W, 3)`, uint8 or uint16.
    ///
    /// The image is copied, so it may have any strides, be read-only, and change afterwards. Pillow images and tensors in
    /// the memory of the CPU are accepted, too. `sequence` is the number of the image, by default the next one; numbers
    /// that are left out count as dropped frames. `capture_time_s` is by default the number divided by the rate.
    ///
    /// Raises `ArgumentTypeError` (a `TypeError`) for another type or dtype, `ArgumentError` (a `ValueError`) for another
    /// shape or an array on another device, `TrackError` for an image of another size or out of order.
    #[pyo3(signature = (image, *, sequence=None, capture_time_s=None))]
    fn track(
        &self,
        py: Python<'_>,
        image: &Bound<'_, PyAny>,
        sequence: Option<u64>,
        capture_time_s: Option<f64>,
    ) -> PyResult<PyReading> {
        let (spare, memory) = py.detach(|| self.lock().tracking.spare());
        let pixels = pixels(image, self.channels, memory)?;
        py.detach(|| {
            let mut state = self.lock();
            if let Some(is_colour) = state.tracking.is_colour() {
                expect_same_format(&pixels, is_colour)?;
            }
            let sequence = sequence.unwrap_or(state.next_sequence);
            let capture_time_s = capture_time_s.unwrap_or(sequence as f64 / self.frames_per_second);
            let reading = state.tracking.track(Frame { sequence, capture_time_s, pixels }, spare)?;
            state.next_sequence = sequence.saturating_add(1);
            Ok(reading)
        })
    }

    /// Makes the next image the new reference: from there on displacement, depth and force are relative to it.
    fn reset(&self, py: Python<'_>) {
        py.detach(|| self.lock().tracking.rezero());
    }

    /// The profile in force.
    #[getter]
    fn profile(&self, py: Python<'_>) -> PyProfile {
        py.detach(|| PyProfile { profile: Profile::clone(&self.lock().tracking.profile) })
    }
}

//! What tracks frames for Python: a tracker with the memory that its readings use.

use std::sync::Arc;

use fingervision_cli::fields_to_compute;
use fingervision_image::{Frame, Pixels};
use fingervision_sink::Field;
use fingervision_touch::{Profile, Tracker};
use pyo3::prelude::*;

use crate::error::OrRaise;
use crate::fields;
use crate::reading::{Pool, PyReading};

/// A tracker that begins with the first frame.
pub(crate) struct Tracking {
    pub(crate) profile: Arc<Profile>,
    requested: Option<Vec<Field>>,
    tracker: Option<Tracker>,
    is_colour: bool,
    pool: Arc<Pool>,
}

impl Tracking {
    pub(crate) fn new(profile: Profile, requested: Option<Vec<Field>>) -> Self {
        Self { profile: Arc::new(profile), requested, tracker: None, is_colour: false, pool: Arc::default() }
    }

    /// Makes the tracker, if there is none yet: wrong profiles and fields are refused here.
    pub(crate) fn begin(&mut self, frame_size: (usize, usize), is_colour: bool) -> PyResult<&mut Tracker> {
        if self.tracker.is_none() {
            let fields = fields_to_compute(self.requested.as_deref(), self.profile.depth_method());
            let tracker = Tracker::new(&self.profile, frame_size, is_colour, fields).or_raise()?;
            fields::expect_all(self.requested.as_deref(), tracker.reading(), &self.profile)?;
            (self.tracker, self.is_colour) = (Some(tracker), is_colour);
        }
        self.tracker.as_mut().ok_or_else(|| pyo3::exceptions::PyRuntimeError::new_err("no tracker"))
    }

    /// Whether the frames have colour, once there was one.
    pub(crate) fn is_colour(&self) -> Option<bool> {
        self.tracker.as_ref().map(|_| self.is_colour)
    }

    /// The image memory of a reading that is not needed any more, and the reading's own.
    pub(crate) fn spare(&self) -> (Option<fingervision_touch::Reading>, Option<Pixels>) {
        self.pool.take().unzip()
    }

    /// The reading of a frame.
    pub(crate) fn track(&mut self, frame: Frame, spare: Option<fingervision_touch::Reading>) -> PyResult<PyReading> {
        let spare = spare.or_else(|| self.spare().0);
        let tracker = self.begin(frame.pixels.size(), frame.pixels.is_colour())?;
        tracker.track(&frame).or_raise()?;
        let reading = tracker.take_reading(spare);
        Ok(PyReading::new(reading, frame.pixels, Arc::clone(&self.profile), Arc::clone(&self.pool)))
    }

    /// Makes the next frame the new reference.
    pub(crate) fn rezero(&mut self) {
        if let Some(tracker) = &mut self.tracker {
            tracker.rezero();
        }
    }
}

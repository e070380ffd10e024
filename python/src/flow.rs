//! The flow on its own, without a sensor.

use std::sync::{Mutex, PoisonError};

use fingervision_flow::{Estimate, FlowEstimator, Picture, Reference, Start};
use fingervision_touch::Profile;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays;
use crate::error::{OrRaise, wrong_value};
use crate::pixels::{Channels, expect_size, load, pixels};
use crate::profile::in_force;
use crate::settings::assignments;

/// Dense flow from a reference to other images of the same size, without a sensor.
///
/// Everything that depends only on the reference is computed once. `set` sets parameters by their paths in a profile, as
/// in `{"flow.finest_level": 1}`; `channels` is the order of colour, `"rgb"` or `"bgr"`; grey images need none.
///
/// Raises `FlowError` for an image that is too small, `ProfileError` for a wrong parameter, and `ArgumentError` and
/// `ArgumentTypeError` as `Tracker.track`.
#[pyclass(frozen, name = "FlowEstimator", module = "fingervision")]
pub(crate) struct PyFlowEstimator {
    state: Mutex<State>,
    channels: Option<Channels>,
    size: (usize, usize),
}

struct State {
    estimator: FlowEstimator,
    reference: Reference,
    picture: Picture,
    estimate: Estimate,
}

/// Flow from a reference to an image.
#[pyclass(frozen, get_all, name = "Flow", module = "fingervision")]
pub(crate) struct PyFlow {
    /// Displacement: `(H, W, 2)` float32, px, x right and y down, at the points of the reference.
    flow: Py<PyAny>,
    /// Predicted standard deviation: `(H, W)` float32, px; infinite where nothing was measured.
    deviation: Py<PyAny>,
    /// Where the flow is a measurement: `(H, W)` bool; elsewhere it is interpolated.
    valid: Py<PyAny>,
    /// Part of the textured patches that match, 0 to 1.
    matched: f32,
}

#[pymethods]
impl PyFlowEstimator {
    #[new]
    #[pyo3(signature = (reference, *, channels=None, set=None))]
    fn new(
        py: Python<'_>,
        reference: &Bound<'_, PyAny>,
        channels: Option<&str>,
        set: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let channels = channels.map(Channels::of).transpose()?;
        let set = assignments(set)?;
        if let Some((key, _)) = set.iter().find(|(key, _)| !key.starts_with("flow.")) {
            return Err(wrong_value(
                format!("set has {key:?}, which is no parameter of the flow"),
                "see the table [flow]",
            ));
        }
        let mut params = in_force(None, || Ok(Profile::default()), &set)?.flow;
        let image = pixels(reference, channels, None)?;
        py.detach(|| {
            params.colour &= image.is_colour();
            let size = image.size();
            let estimator = FlowEstimator::new(size.0, size.1, &params).or_raise()?;
            let (mut picture, mut reference) = (estimator.picture(), estimator.reference());
            load(&mut picture, &image)?;
            estimator.prepare(&picture, &mut reference);
            let estimate = Estimate::new(size.0, size.1);
            Ok(Self { state: Mutex::new(State { estimator, reference, picture, estimate }), channels, size })
        })
    }

    /// The flow to an image, found without any knowledge of it, even if it is large.
    ///
    /// Raises `ArgumentError` if the image has another size than the reference, and as `Tracker.track`.
    fn estimate(&self, py: Python<'_>, image: &Bound<'_, PyAny>) -> PyResult<PyFlow> {
        let image = pixels(image, self.channels, None)?;
        expect_size(&image, self.size)?;
        let found = py.detach(|| {
            let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
            let State { estimator, reference, picture, estimate } = &mut *state;
            load(picture, &image)?;
            // What was found for another image has no influence.
            estimator.restart();
            estimator.estimate(reference, picture, Start::Search(None), estimate);
            PyResult::Ok(estimate.clone())
        })?;
        Ok(PyFlow {
            flow: arrays::interleaved(py, [&found.flow.u, &found.flow.v])?,
            deviation: arrays::plane(py, &found.deviation)?,
            valid: arrays::mask(py, &found.valid)?,
            matched: found.matched,
        })
    }
}

//! Simulated presses with their exact truth.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use fingervision_gel::{EarlyEnd, PressCache, ReadyMade, Scene, Simulation};
use fingervision_simulation::simulated_profile;
use numpy::ToPyArray;
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays;
use crate::error::{OrRaise, exception, wrong_value};
use crate::profile::PyProfile;
use crate::readings::go_on_unless_interrupted;
use crate::settings::{assignments, pairs};

/// A simulated press, from `fingervision.simulate`: a sequence of `SimulatedFrame`, which are rendered when asked for.
#[pyclass(frozen, sequence, name = "Simulation", module = "fingervision")]
pub(crate) struct PySimulation {
    simulation: Mutex<Simulation>,
    scene: Scene,
    frames: usize,
}

/// A frame of a simulated press and its truth. Fields lie on the grid of the first frame.
#[pyclass(frozen, get_all, name = "SimulatedFrame", module = "fingervision")]
pub(crate) struct PySimulatedFrame {
    /// The camera image: `(H, W, 3)` or `(H, W)` uint8.
    image: Py<PyAny>,
    /// True displacement in the image: `(H, W, 2)` float32, px; NaN where there is no gel.
    flow: Py<PyAny>,
    /// True depth: `(H, W)` float32, mm, positive pressed in; NaN where there is no gel.
    depth: Py<PyAny>,
    /// True displacement of the surface: `(H, W, 3)` float32, mm, gel space; NaN where there is no gel.
    displacement: Py<PyAny>,
    /// Where the gel touches the indenter: `(H, W)` bool.
    contact: Py<PyAny>,
    /// Where the camera sees the point: `(H, W)` bool.
    visible: Py<PyAny>,
    /// True force of the indenter on the gel: `(3,)` float64, N, pressing is +z.
    force: Py<PyAny>,
    /// True torque on the gel about z through the centre of contact, N mm.
    torque: f64,
    /// Indentation depth of the indenter, mm.
    depth_mm: f64,
}

/// The frames one after another.
#[pyclass(frozen, name = "SimulatedFrames", module = "fingervision")]
pub(crate) struct PySimulatedFrames {
    simulation: Py<PySimulation>,
    next: AtomicUsize,
}

#[pymethods]
impl PySimulatedFrames {
    fn __iter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<PySimulatedFrame>> {
        let simulation = self.simulation.get();
        let at = self.next.fetch_add(1, Ordering::Relaxed);
        (at < simulation.frames).then(|| simulation.made(py, at)).transpose()
    }
}

#[pymethods]
impl PySimulation {
    fn __iter__(slf: Py<Self>) -> PySimulatedFrames {
        PySimulatedFrames { simulation: slf, next: AtomicUsize::new(0) }
    }

    fn __len__(&self) -> usize {
        self.frames
    }

    fn __getitem__(&self, py: Python<'_>, index: isize) -> PyResult<PySimulatedFrame> {
        let at = if index < 0 { index + self.frames.cast_signed() } else { index };
        let at = usize::try_from(at).ok().filter(|at| *at < self.frames);
        let at = at.ok_or_else(|| PyIndexError::new_err(format!("frame {index} of {}", self.frames)))?;
        self.made(py, at)
    }

    /// The profile of the simulated sensor.
    #[getter]
    fn profile(&self) -> PyProfile {
        PyProfile { profile: simulated_profile(&self.scene) }
    }

    /// The text of the scene's file, every default written out.
    fn to_toml(&self) -> String {
        self.scene.to_toml()
    }

    fn __repr__(&self) -> String {
        format!("Simulation({:?}, {} frames)", self.scene.name, self.frames)
    }
}

impl PySimulation {
    fn lock(&self) -> MutexGuard<'_, Simulation> {
        self.simulation.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Renders a frame.
    fn made(&self, py: Python<'_>, at: usize) -> PyResult<PySimulatedFrame> {
        let (pixels, truth, depth_mm, state) = py.detach(|| {
            let mut simulation = self.lock();
            let pixels = simulation.frame(at).or_raise()?.clone();
            let truth = simulation.truth(at).or_raise()?.clone();
            let state = &simulation.states()[at];
            PyResult::Ok((pixels, truth, simulation.poses()[at].depth_mm, (state.force_n, state.torque_nmm[2])))
        })?;
        Ok(PySimulatedFrame {
            image: arrays::image(py, &pixels)?,
            flow: arrays::vectors(py, truth.flow.size(), truth.flow.values())?,
            depth: arrays::plane(py, &truth.depth)?,
            displacement: arrays::vectors(py, truth.displacement.size(), truth.displacement.values())?,
            contact: arrays::mask(py, &truth.contact)?,
            visible: arrays::mask(py, &truth.visible)?,
            force: state.0.to_pyarray(py).into_any().unbind(),
            torque: state.1,
            depth_mm,
        })
    }
}

/// Solves a press of the simulated sensor.
///
/// `scene` is the name of a ready-made scene (`fingervision.scenes()` lists them) or the path of a scene file; `toml` is
/// the text of one instead. `set` sets values of the scene by their paths, as in `{"gel.poissons_ratio": 0.35}`;
/// `draft=True` takes a coarse mesh, seconds instead of minutes; `seed` is that of pattern and noise. Solved presses are
/// kept on the disk unless `cache=False`. Ctrl-C ends it.
///
/// Raises `SceneError` if the scene is impossible or cannot be solved to its end.
#[pyfunction]
#[pyo3(signature = (scene=None, *, toml=None, set=None, draft=false, seed=None, cache=true))]
pub(crate) fn simulate(
    py: Python<'_>,
    scene: Option<&str>,
    toml: Option<&str>,
    set: Option<&Bound<'_, PyDict>>,
    draft: bool,
    seed: Option<u64>,
    cache: bool,
) -> PyResult<PySimulation> {
    let mut scene = match (scene, toml) {
        (Some(name), None) => Scene::find(name).or_raise()?,
        (None, Some(text)) => Scene::from_toml(text).or_raise()?,
        _ => return Err(wrong_value("a scene or toml is needed, and not both", "see fingervision.scenes()")),
    };
    if draft {
        scene.make_draft();
    }
    if let Some(seed) = seed {
        scene.set_seed(seed);
    }
    scene.set_all(pairs(&assignments(set)?)).or_raise()?;
    let cache = if cache { PressCache::standard() } else { PressCache::OFF };
    py.detach(|| {
        let mut simulation = Simulation::new(&scene).or_raise()?;
        let mut interrupted = None;
        let solved = simulation.solve(&cache, &mut |_| go_on_unless_interrupted(&mut interrupted)).or_raise();
        let end = solved.map(|press| press.end.clone());
        if let Some(error) = interrupted {
            return Err(error);
        }
        if let Some(end) = end? {
            return Err(early(&end));
        }
        let frames = simulation.states().len();
        Ok(PySimulation { simulation: Mutex::new(simulation), scene, frames })
    })
}

fn early(end: &EarlyEnd) -> PyErr {
    exception("SceneError", &end.to_string(), end.hint().as_deref())
}

/// The names of the ready-made scenes, with a sentence on each.
#[pyfunction]
pub(crate) fn scenes(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let scenes = PyDict::new(py);
    for ready in ReadyMade::ALL {
        scenes.set_item(ready.name, ready.scene().about)?;
    }
    Ok(scenes)
}

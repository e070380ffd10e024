//! Readings.

use std::sync::{Arc, Mutex, PoisonError};

use fingervision_image::Pixels;
use fingervision_sink::Field;
use fingervision_touch::{Profile, Reading, ReadingNumbers};
use numpy::ToPyArray;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyTuple;

use crate::error::exception;
use crate::{arrays, fields};

/// Readings that a pool keeps.
const MOST_SPARE: usize = 4;

/// Memory of readings that Python has given up, for the next ones of the same tracker.
#[derive(Debug, Default)]
pub(crate) struct Pool(Mutex<Vec<(Reading, Pixels)>>);

impl Pool {
    pub(crate) fn take(&self) -> Option<(Reading, Pixels)> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).pop()
    }

    fn put(&self, reading: Reading, image: Pixels) {
        let mut spare = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if spare.len() < MOST_SPARE {
            spare.push((reading, image));
        }
    }
}

/// An array that is made when it is first asked for.
struct Lazy(PyOnceLock<Py<PyAny>>);

impl Default for Lazy {
    fn default() -> Self {
        Self(PyOnceLock::new())
    }
}

#[derive(Default)]
struct Arrays {
    image: Lazy,
    flow: Lazy,
    deviation: Lazy,
    valid: Lazy,
    density: Lazy,
    depth: Lazy,
    depth_deviation: Lazy,
    depth_valid: Lazy,
    contact: Lazy,
    displacement: Lazy,
    traction: Lazy,
    force: Lazy,
}

/// Everything that was computed from one frame. All fields lie on the reference grid: they belong to points of the gel.
///
/// An array is made when it is first asked for, and is the same object from then on. It is a copy of its own: it stays as
/// it is while tracking goes on. `H` and `W` are rows and columns of the region of interest. A field that was not
/// requested, or that the profile does not allow, raises `FieldError`, which is also an `AttributeError`.
#[pyclass(frozen, name = "Reading", module = "fingervision")]
pub(crate) struct PyReading {
    reading: Reading,
    pixels: Pixels,
    profile: Arc<Profile>,
    pool: Arc<Pool>,
    arrays: Arrays,
}

impl PyReading {
    pub(crate) fn new(reading: Reading, pixels: Pixels, profile: Arc<Profile>, pool: Arc<Pool>) -> Self {
        Self { reading, pixels, profile, pool, arrays: Arrays::default() }
    }

    fn present<'a, T>(&self, field: Field, value: Option<&'a T>) -> PyResult<&'a T> {
        value.ok_or_else(|| fields::absence(field, &self.profile))
    }

    /// Refuses force and torque of a sensor that never has them.
    fn expect_force(&self) -> PyResult<()> {
        self.present(Field::Contact, self.reading.contact.as_ref())?;
        if self.profile.gel.is_some_and(|gel| gel.youngs_modulus_mpa.is_some()) {
            return Ok(());
        }
        let message = format!("there is no force in readings of the sensor {:?}", self.profile.name);
        Err(exception("FieldError", &message, Some("give the gel's stiffness: set={\"gel.youngs_modulus_mpa\": 0.6}")))
    }
}

/// The array of a cell, made by `make` at the first time.
fn once(py: Python<'_>, cell: &Lazy, make: impl FnOnce() -> PyResult<Py<PyAny>>) -> PyResult<Py<PyAny>> {
    cell.0.get_or_try_init(py, make).map(|array| array.clone_ref(py))
}

#[pymethods]
impl PyReading {
    /// The frame's number in its source, from 0; numbers of missing frames are skipped.
    #[getter]
    fn sequence(&self) -> u64 {
        self.reading.sequence
    }

    /// When the frame was exposed, s, on the source's clock.
    #[getter]
    fn capture_time_s(&self) -> f64 {
        self.reading.capture_time_s
    }

    /// Frames that the source dropped since tracking began.
    #[getter]
    fn dropped_frames(&self) -> u64 {
        self.reading.dropped_frames
    }

    /// Number of the reference that the frame was matched with, from 0.
    #[getter]
    fn reference_id(&self) -> u64 {
        self.reading.reference_id
    }

    /// How well the frame matches its reference: root mean square of the residuals, grey levels from 0 to 255.
    #[getter]
    fn photometric_error(&self) -> f32 {
        self.reading.photometric_error
    }

    /// Mean grey level of the region of interest, 0 to 255, whatever the camera's depth.
    #[getter]
    fn mean_level(&self) -> f32 {
        self.reading.mean_level
    }

    /// Part of the pixels of the region of interest of which a channel is saturated, 0 to 1.
    #[getter]
    fn saturated_part(&self) -> f32 {
        self.reading.saturated_part
    }

    /// Sharpness of the region of interest, dimensionless; compare it only with other images of this sensor.
    #[getter]
    fn sharpness(&self) -> f32 {
        self.reading.sharpness
    }

    /// Time that tracking took, ms. It is the only value that differs from run to run.
    #[getter]
    fn latency_ms(&self) -> f64 {
        self.reading.latency_ms
    }

    /// The names of the reading's problems, as in `("lost",)`; `fingervision.FLAGS` explains them.
    #[getter]
    fn flags<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let names: Vec<&str> = self.reading.flags.iter().map(fingervision_touch::Flag::name).collect();
        PyTuple::new(py, names)
    }

    /// Part of the image that never tracks while the gel around it does, or that dirt hides, 0 to 1.
    #[getter]
    fn damaged_part(&self) -> f32 {
        self.reading.damaged_part
    }

    /// The names of the fields that this reading has.
    #[getter]
    fn fields<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let present = Field::ALL.into_iter().filter(|field| field.is_in(&self.reading));
        PyTuple::new(py, present.map(Field::name).collect::<Vec<_>>())
    }

    /// The camera image: `(H, W)` or `(H, W, 3)` in red, green, blue; uint8 or uint16; the whole frame.
    #[getter]
    fn image(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        once(py, &self.arrays.image, || arrays::image(py, &self.pixels))
    }

    /// Displacement in the image: `(H, W, 2)` float32, px, x right and y down. `x + flow(x)` is the current position.
    #[getter]
    fn flow(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let flow = &self.reading.flow;
        once(py, &self.arrays.flow, || arrays::interleaved(py, [&flow.u, &flow.v]))
    }

    /// Predicted standard deviation of the flow: `(H, W)` float32, px; infinite where nothing was measured.
    #[getter]
    fn deviation(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        once(py, &self.arrays.deviation, || arrays::plane(py, &self.reading.deviation))
    }

    /// Where flow, density and depth from density are valid: `(H, W)` bool. Elastic depth has `depth_valid`.
    #[getter]
    fn valid(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        once(py, &self.arrays.valid, || arrays::mask(py, &self.reading.valid))
    }

    /// Density feature: `(H, W)` float32, dimensionless, 0 at rest, positive where the surface expands.
    #[getter]
    fn density(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let density = self.present(Field::Density, self.reading.density.as_ref())?;
        once(py, &self.arrays.density, || arrays::plane(py, density))
    }

    /// Depth: `(H, W)` float32, mm, positive pressed in, 0 where it is not valid (`depth_valid`).
    #[getter]
    fn depth(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let depth = self.present(Field::Depth, self.reading.depth.as_ref())?;
        once(py, &self.arrays.depth, || arrays::plane(py, depth))
    }

    /// Expected error of an elastic depth: `(H, W)` float32, mm; infinite where depth is not valid.
    #[getter]
    fn depth_deviation(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let deviation = self.present(Field::DepthDeviation, self.reading.depth_deviation.as_ref())?;
        once(py, &self.arrays.depth_deviation, || arrays::plane(py, deviation))
    }

    /// Where depth is valid, and contact and displacement with it: `(H, W)` bool.
    #[getter]
    fn depth_valid(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let Some(deviation) = &self.reading.depth_deviation else {
            self.present(Field::Depth, self.reading.depth.as_ref())?;
            return self.valid(py);
        };
        once(py, &self.arrays.depth_valid, || arrays::mask_where(py, deviation, f32::is_finite))
    }

    /// Where the gel touches something: `(H, W)` bool; with elastic depth.
    #[getter]
    fn contact(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let contact = self.present(Field::Contact, self.reading.contact.as_ref())?;
        once(py, &self.arrays.contact, || arrays::mask(py, contact))
    }

    /// Displacement of the surface: `(H, W, 3)` float32, mm, gel space: x right, y down, z towards the camera.
    #[getter]
    fn displacement(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let [x, y, z] = self.present(Field::Displacement, self.reading.displacement.as_ref())?;
        once(py, &self.arrays.displacement, || arrays::interleaved(py, [x, y, z]))
    }

    /// Traction on the gel: `(h, w, 3)` float32, MPa, gel space; on square cells of `traction_cell_mm`, centred on the gel.
    #[getter]
    fn traction(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let grid = self.present(Field::Traction, self.reading.traction.as_ref())?;
        once(py, &self.arrays.traction, || arrays::vectors(py, (grid.columns, grid.rows), &grid.traction_mpa))
    }

    /// Side of a cell of `traction`, mm.
    #[getter]
    fn traction_cell_mm(&self) -> PyResult<f64> {
        Ok(self.present(Field::Traction, self.reading.traction.as_ref())?.cell_mm)
    }

    /// Force of the object on the gel: `(3,)` float32, N, gel space, pressing is +z; NaN if this frame has none.
    #[getter]
    fn force(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.expect_force()?;
        let force = self.reading.force_n.unwrap_or([f32::NAN; 3]);
        once(py, &self.arrays.force, || Ok(force.to_pyarray(py).into_any().unbind()))
    }

    /// Torque on the gel about z through the centre of contact, N mm; NaN if this frame has none.
    #[getter]
    fn torque(&self) -> PyResult<f32> {
        self.expect_force()?;
        Ok(self.reading.torque_nmm.unwrap_or(f32::NAN))
    }

    /// Largest depth where it is valid, mm; NaN if this frame has none.
    #[getter]
    fn max_depth_mm(&self) -> PyResult<f32> {
        self.present(Field::Depth, self.reading.depth.as_ref())?;
        Ok(self.reading.max_depth_mm.unwrap_or(f32::NAN))
    }

    /// Area of contact in the undeformed surface, mm²; NaN if this frame has none. With elastic depth.
    #[getter]
    fn contact_area_mm2(&self) -> PyResult<f32> {
        self.present(Field::Contact, self.reading.contact.as_ref())?;
        Ok(self.reading.contact_area_mm2.unwrap_or(f32::NAN))
    }

    fn __repr__(&self) -> String {
        let ReadingNumbers { sequence, capture_time_s, max_depth_mm, flags, .. } = &self.reading.numbers;
        let depth = max_depth_mm.map_or(String::new(), |depth| format!(", max_depth_mm={depth:.3}"));
        format!("Reading(sequence={sequence}, capture_time_s={capture_time_s:.4}{depth}, flags=\"{flags}\")")
    }
}

impl Drop for PyReading {
    fn drop(&mut self) {
        let reading = std::mem::replace(&mut self.reading, Reading::new(0, 0));
        let empty = Pixels::Grey8(fingervision_image::Image::filled(0, 0, 0));
        self.pool.put(reading, std::mem::replace(&mut self.pixels, empty));
    }
}

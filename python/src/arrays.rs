//! Results out: planes as new NumPy arrays, which own their memory.

use fingervision_image::{Image, Pixels};
use numpy::ndarray::{Array2, Array3, ArrayView2, ArrayView3, ShapeError};
use numpy::{Element, IntoPyArray, ToPyArray};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// A plane, `(H, W)`.
pub(crate) fn plane<T: Element + Copy>(py: Python<'_>, image: &Image<T>) -> PyResult<Py<PyAny>> {
    let view = ArrayView2::from_shape((image.height(), image.width()), image.values()).map_err(impossible)?;
    Ok(view.to_pyarray(py).into_any().unbind())
}

/// A plane of 0 and 1 as `bool`, `(H, W)`.
pub(crate) fn mask(py: Python<'_>, image: &Image<u8>) -> PyResult<Py<PyAny>> {
    mask_where(py, image, |value| value == 1)
}

/// Where a condition holds, as `bool`, `(H, W)`.
pub(crate) fn mask_where<T: Copy>(py: Python<'_>, image: &Image<T>, holds: impl Fn(T) -> bool) -> PyResult<Py<PyAny>> {
    let values = image.values().iter().map(|&value| holds(value)).collect();
    let array = Array2::from_shape_vec((image.height(), image.width()), values).map_err(impossible)?;
    Ok(array.into_pyarray(py).into_any().unbind())
}

/// Planes interleaved, `(H, W, N)`.
pub(crate) fn interleaved<const N: usize>(py: Python<'_>, planes: [&Image<f32>; N]) -> PyResult<Py<PyAny>> {
    let (width, height) = planes[0].size();
    let mut values = vec![0.0; N * width * height];
    for (channel, plane) in planes.into_iter().enumerate() {
        values.chunks_exact_mut(N).zip(plane.values()).for_each(|(to, from)| to[channel] = *from);
    }
    let array = Array3::from_shape_vec((height, width, N), values).map_err(impossible)?;
    Ok(array.into_pyarray(py).into_any().unbind())
}

/// Vectors in rows, `(H, W, N)`.
pub(crate) fn vectors<T: Element + Copy, const N: usize>(
    py: Python<'_>,
    (width, height): (usize, usize),
    values: &[[T; N]],
) -> PyResult<Py<PyAny>> {
    let view = ArrayView3::from_shape((height, width, N), values.as_flattened()).map_err(impossible)?;
    Ok(view.to_pyarray(py).into_any().unbind())
}

/// Vectors one after another, `(N, 3)`.
pub(crate) fn rows<T: Element + Copy>(py: Python<'_>, values: &[[T; 3]]) -> PyResult<Py<PyAny>> {
    let view = ArrayView2::from_shape((values.len(), 3), values.as_flattened()).map_err(impossible)?;
    Ok(view.to_pyarray(py).into_any().unbind())
}

/// A camera image: `(H, W)` or `(H, W, 3)` in red, green, blue; uint8 or uint16.
pub(crate) fn image(py: Python<'_>, pixels: &Pixels) -> PyResult<Py<PyAny>> {
    match pixels {
        Pixels::Grey8(image) => plane(py, image),
        Pixels::Grey16(image) => plane(py, image),
        Pixels::Rgb8(image) => vectors(py, image.size(), image.values()),
        Pixels::Rgb16(image) => vectors(py, image.size(), image.values()),
    }
}

/// An image always has as many values as pixels.
fn impossible(error: ShapeError) -> PyErr {
    PyRuntimeError::new_err(error.to_string())
}

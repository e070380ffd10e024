//! The cameras of this machine.

use pyo3::prelude::*;

/// A camera that is plugged in, from `fingervision.cameras`.
#[pyclass(frozen, get_all, name = "CameraInfo", module = "fingervision")]
pub(crate) struct PyCameraInfo {
    /// Its id, which stays the same when cameras are plugged in: `fingervision.open("camera:ID")`.
    id: String,
    /// Its name.
    name: String,
    /// The node in `/dev`, which may change.
    path: String,
    /// The kernel's driver.
    driver: String,
    /// Its serial number, if it has one.
    serial: Option<String>,
    /// Whether it can be opened.
    is_accessible: bool,
}

#[pymethods]
impl PyCameraInfo {
    fn __repr__(&self) -> String {
        format!("CameraInfo(id={:?}, name={:?}, path={:?})", self.id, self.name, self.path)
    }
}

/// The cameras that are plugged in; empty where cameras are not supported, which is everywhere but on Linux.
#[pyfunction]
pub(crate) fn cameras(py: Python<'_>) -> Vec<PyCameraInfo> {
    py.detach(found)
}

#[cfg(target_os = "linux")]
fn found() -> Vec<PyCameraInfo> {
    use fingervision_camera::{Access, CameraInfo, Video4Linux};
    let info = |CameraInfo { node, access, .. }| PyCameraInfo {
        id: node.id,
        name: node.card,
        path: node.path.display().to_string(),
        driver: node.driver,
        serial: node.serial,
        is_accessible: access == Access::Open,
    };
    fingervision_camera::cameras(&Video4Linux::default()).into_iter().map(info).collect()
}

#[cfg(not(target_os = "linux"))]
fn found() -> Vec<PyCameraInfo> {
    Vec::new()
}

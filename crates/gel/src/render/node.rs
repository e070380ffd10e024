//! A point of the surface, relative to the camera.

/// A point of the surface relative to the camera.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Node {
    /// From the camera's centre, mm: along x, along y and down, against z. So points in front of the camera have a
    /// positive last value.
    pub(crate) place: [f64; 3],
    /// Its pixel, px; NaN where the camera does not see it.
    pub(crate) px: [f64; 2],
    /// Gain of the light.
    pub(crate) gain: f64,
}

pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

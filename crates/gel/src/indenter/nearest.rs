//! The position of a point relative to a face.

/// The vector from the nearest point of a face to a point outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Nearest {
    pub(super) distance_mm: f64,
    /// Unit vector: the gradient of the distance.
    pub(super) away: [f64; 2],
    /// Second derivative of the distance across that direction, 1/mm; along it there is none.
    pub(super) bend_per_mm: f64,
}

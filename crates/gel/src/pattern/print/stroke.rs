//! Lines on the page.

/// A chain of straight black lines with round ends and joints.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Stroke {
    pub(super) points_mm: Vec<[f64; 2]>,
    pub(super) width_mm: f64,
}

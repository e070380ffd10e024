//! The flow field: a displacement at every pixel of the reference.

use fingervision_image::Image;

/// A displacement in px at every reference pixel: the point at `x` in the reference lies at `x + (u, v)` in the
/// current image.
#[derive(Debug, Clone, PartialEq)]
pub struct FlowField {
    /// Displacement to the right, px.
    pub u: Image<f32>,
    /// Displacement downwards, px.
    pub v: Image<f32>,
}

impl FlowField {
    /// Zero displacement everywhere.
    #[must_use]
    pub fn zero(width: usize, height: usize) -> Self {
        Self { u: Image::filled(width, height, 0.0), v: Image::filled(width, height, 0.0) }
    }

    /// Columns and rows, px.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        self.u.size()
    }

    /// Sets both components everywhere.
    pub fn fill(&mut self, value: f32) {
        self.u.values_mut().fill(value);
        self.v.values_mut().fill(value);
    }

    /// Copies the values of `other`; allocates nothing if the sizes are equal.
    pub fn copy_from(&mut self, other: &Self) {
        self.u.copy_from(&other.u);
        self.v.copy_from(&other.v);
    }
}

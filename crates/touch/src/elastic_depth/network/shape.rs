//! The shape of a layer.

/// Output channels computed together: one or two registers.
pub(super) const LANES: usize = 16;

/// Cells along a tile, which are computed together where this takes fewer products.
pub(super) const TILE: usize = 2;

/// The shape of a layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Shape {
    pub(super) inputs: usize,
    pub(super) outputs: usize,
    pub(super) side: usize,
    pub(super) stride: usize,
}

impl Shape {
    /// Weights and biases.
    pub(super) fn len(self) -> usize {
        self.outputs * (self.inputs * self.side * self.side + 1)
    }
}

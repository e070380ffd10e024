//! A stack of channels over a grid, with a rim of zeros.

/// `channels` values at every cell of a grid, side by side, and one ring of cells around it that stays zero, because a
/// convolution of 3×3 reads one cell beyond the border.
#[derive(Debug, Clone)]
pub(super) struct Plane {
    pub(super) columns: usize,
    pub(super) rows: usize,
    pub(super) channels: usize,
    values: Vec<f32>,
}

impl Plane {
    pub(super) fn new((columns, rows): (usize, usize), channels: usize) -> Self {
        Self { columns, rows, channels, values: vec![0.0; (columns + 2) * (rows + 2) * channels] }
    }

    /// Distance from one row of the grid to the next, in values.
    pub(super) fn stride(&self) -> usize {
        (self.columns + 2) * self.channels
    }

    /// All values, the rim included.
    pub(super) fn values(&self) -> &[f32] {
        &self.values
    }

    /// The cells of a row without its rim.
    pub(super) fn row(&self, row: usize) -> &[f32] {
        &self.values[(row + 1) * self.stride() + self.channels..][..self.columns * self.channels]
    }

    /// The cells of a row without its rim, to be written.
    pub(super) fn row_mut(&mut self, row: usize) -> &mut [f32] {
        let start = (row + 1) * self.stride() + self.channels;
        &mut self.values[start..][..self.columns * self.channels]
    }
}

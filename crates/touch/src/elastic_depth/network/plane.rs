//! A stack of channels over a grid, with a rim of zeros.

use std::ops::Range;

use super::shape::{LANES, TILE};

/// `channels` values at every cell of a grid, side by side, and one ring of cells around it that stays zero, because a
/// convolution of 3×3 reads one cell beyond the border. Sides that are no multiple of a tile have more zeros behind them.
#[derive(Debug, Clone)]
pub(super) struct Plane {
    pub(super) columns: usize,
    pub(super) rows: usize,
    pub(super) channels: usize,
    values: Vec<f32>,
}

impl Plane {
    pub(super) fn new((columns, rows): (usize, usize), channels: usize) -> Self {
        Self {
            columns,
            rows,
            channels,
            values: vec![0.0; stride(columns, channels) * (rows.next_multiple_of(TILE) + 2)],
        }
    }

    /// Distance from one row of the grid to the next, in values.
    pub(super) fn stride(&self) -> usize {
        stride(self.columns, self.channels)
    }

    /// All values, the rim included.
    pub(super) fn values(&self) -> &[f32] {
        &self.values
    }

    /// The cells of a row without its rim.
    pub(super) fn row(&self, row: usize) -> &[f32] {
        &self.values[(row + 1) * self.stride() + self.channels..][..self.columns * self.channels]
    }

    /// [`LANES`] channels of a cell, from one of them on.
    #[inline(always)]
    pub(super) fn cell(&self, (column, row): (usize, usize), first: usize) -> &[f32] {
        let start = (row + 1) * self.stride() + (column + 1) * self.channels + first;
        &self.values[start..][..LANES]
    }

    /// The cells of a row without its rim, to be written.
    pub(super) fn row_mut(&mut self, row: usize) -> &mut [f32] {
        let start = (row + 1) * self.stride() + self.channels;
        &mut self.values[start..][..self.columns * self.channels]
    }

    /// All rows, to be written.
    pub(super) fn rows_mut(&mut self) -> Rows<'_> {
        let Self { columns, rows, channels, .. } = *self;
        let stride = self.stride();
        Rows { first: 0, count: rows, columns, channels, stride, values: &mut self.values[stride..] }
    }
}

/// Distance from one row of a grid with so many columns to the next, in values.
fn stride(columns: usize, channels: usize) -> usize {
    (columns.next_multiple_of(TILE) + 2) * channels
}

/// Some rows of a plane, to be written.
#[derive(Debug)]
pub(super) struct Rows<'a> {
    first: usize,
    count: usize,
    pub(super) columns: usize,
    channels: usize,
    /// Distance from one row to the next.
    stride: usize,
    /// From the rim of the first row on.
    values: &'a mut [f32],
}

impl Rows<'_> {
    /// The rows before one and those from it on; rows are counted from the top of the plane.
    pub(super) fn split_at(self, row: usize) -> (Self, Self) {
        let upper = row - self.first;
        let (values, lower) = self.values.split_at_mut(upper * self.stride);
        let lower = Self { first: row, count: self.count - upper, values: lower, ..self };
        (Self { count: upper, values, ..self }, lower)
    }

    /// The rows, counted from the top of the plane.
    pub(super) fn range(&self) -> Range<usize> {
        self.first..self.first + self.count
    }

    /// [`LANES`] channels of a cell, from one of them on; the row is counted from the top of the plane.
    #[inline(always)]
    pub(super) fn cell_mut(&mut self, (column, row): (usize, usize), first: usize) -> &mut [f32] {
        let start = (row - self.first) * self.stride + (column + 1) * self.channels + first;
        &mut self.values[start..][..LANES]
    }
}

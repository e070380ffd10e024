//! The flow of a cell that dirt hides, interpolated between that beside it.

use fingervision_flow::{Estimate, FlowField};

use super::CELL;

/// A cell that dirt hides, and the nearest pixels beside it that are not hidden.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hidden {
    left: usize,
    top: usize,
    /// Their columns to the left and right, px.
    beside: [usize; 2],
    /// Their rows above and below, px.
    along: [usize; 2],
}

impl Hidden {
    /// The cell at a column and row of a grid of this size. The cells at the border of the grid are not hidden.
    pub(super) fn new(
        (x, y): (usize, usize),
        (columns, rows): (usize, usize),
        is_hidden: impl Fn(usize, usize) -> bool,
    ) -> Self {
        let left = (0..x).rev().find(|&x| !is_hidden(x, y)).unwrap_or(0);
        let right = (x + 1..columns).find(|&x| !is_hidden(x, y)).unwrap_or(columns - 1);
        let above = (0..y).rev().find(|&y| !is_hidden(x, y)).unwrap_or(0);
        let below = (y + 1..rows).find(|&y| !is_hidden(x, y)).unwrap_or(rows - 1);
        let first = |cell: usize| cell * CELL;
        let last = |cell: usize| (cell + 1) * CELL - 1;
        Self { left: first(x), top: first(y), beside: [last(left), first(right)], along: [last(above), first(below)] }
    }

    /// Replaces the flow in the cell and marks it as not valid.
    pub(super) fn replace(&self, estimate: &mut Estimate) {
        for y in self.top..self.top + CELL {
            let cell = self.left..self.left + CELL;
            estimate.valid.row_mut(y)[cell.clone()].fill(0);
            estimate.deviation.row_mut(y)[cell.clone()].fill(f32::INFINITY);
            for x in cell {
                let [u, v] = self.between(&estimate.flow, x, y);
                (estimate.flow.u.row_mut(y)[x], estimate.flow.v.row_mut(y)[x]) = (u, v);
            }
        }
    }

    /// The flow at a pixel, px, from those to the left and right, above and below, weighted by one over the distance.
    fn between(&self, flow: &FlowField, x: usize, y: usize) -> [f32; 2] {
        let beside = self.beside.map(|column| (column.abs_diff(x), (column, y)));
        let along = self.along.map(|row| (row.abs_diff(y), (x, row)));
        let (mut sum, mut weights) = ([0.0; 2], 0.0);
        for (distance, (x, y)) in beside.into_iter().chain(along) {
            let weight = 1.0 / distance as f32;
            sum = [sum[0] + weight * flow.u.at(x, y), sum[1] + weight * flow.v.at(x, y)];
            weights += weight;
        }
        sum.map(|sum| sum / weights)
    }
}

//! The flow of a cell that dirt hides, interpolated between that beside it.

use fingervision_flow::{Estimate, FlowField};

use super::CELL;

/// A cell without flow, and where flow is known beside it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hidden {
    left: usize,
    top: usize,
    /// The nearest columns to the left and right that are not hidden, px; absent beyond the cells.
    columns: [Option<usize>; 2],
    /// The nearest rows above and below that are not hidden, px.
    rows: [Option<usize>; 2],
}

impl Hidden {
    /// The cell at a column and row of a grid of cells, of which some are known.
    pub(super) fn new(
        (x, y): (usize, usize),
        (columns, rows): (usize, usize),
        is_known: impl Fn(usize, usize) -> bool,
    ) -> Self {
        let last = |cell: usize| (cell + 1) * CELL - 1;
        let first = |cell: usize| cell * CELL;
        Self {
            left: first(x),
            top: first(y),
            columns: [
                (0..x).rev().find(|&x| is_known(x, y)).map(last),
                (x + 1..columns).find(|&x| is_known(x, y)).map(first),
            ],
            rows: [
                (0..y).rev().find(|&y| is_known(x, y)).map(last),
                (y + 1..rows).find(|&y| is_known(x, y)).map(first),
            ],
        }
    }

    /// Replaces the flow in the cell and marks it as not valid.
    pub(super) fn replace(&self, estimate: &mut Estimate) {
        for y in self.top..self.top + CELL {
            let cell = self.left..self.left + CELL;
            estimate.valid.row_mut(y)[cell.clone()].fill(0);
            estimate.deviation.row_mut(y)[cell.clone()].fill(f32::INFINITY);
            for x in cell {
                if let Some([u, v]) = self.between(&estimate.flow, x, y) {
                    (estimate.flow.u.row_mut(y)[x], estimate.flow.v.row_mut(y)[x]) = (u, v);
                }
            }
        }
    }

    /// The flow at a pixel, px, from the nearest known one to the left and right, above and below, weighted by one over the distance.
    fn between(&self, flow: &FlowField, x: usize, y: usize) -> Option<[f32; 2]> {
        let beside = self.columns.map(|column| column.map(|column| (column.abs_diff(x), (column, y))));
        let along = self.rows.map(|row| row.map(|row| (row.abs_diff(y), (x, row))));
        let (mut sum, mut weights) = ([0.0; 2], 0.0);
        for (distance, (x, y)) in beside.into_iter().chain(along).flatten() {
            let weight = 1.0 / distance as f32;
            sum = [sum[0] + weight * flow.u.at(x, y), sum[1] + weight * flow.v.at(x, y)];
            weights += weight;
        }
        (weights > 0.0).then(|| sum.map(|sum| sum / weights))
    }
}

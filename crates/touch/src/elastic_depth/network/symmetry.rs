//! The symmetries of the gel: mirror images and quarter turns.
//!
//! The result must not depend on the orientation of the gel, but the network has learned this only approximately. The
//! mean of its estimates over all symmetries has a smaller error than a single estimate.

use super::INPUTS;

/// A mirror image, a quarter turn or both, of a grid of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::elastic_depth) struct Symmetry {
    /// Whether left and right are exchanged.
    across: bool,
    /// Whether top and bottom are exchanged.
    down: bool,
    /// Whether columns and rows are exchanged afterwards.
    transposed: bool,
}

impl Symmetry {
    /// The identity.
    pub(in crate::elastic_depth) const PLAIN: Self = Self { across: false, down: false, transposed: false };

    /// All symmetries that keep the size of a grid: eight for a square, otherwise four.
    pub(in crate::elastic_depth) fn all((columns, rows): (usize, usize)) -> Vec<Self> {
        let mirrors = |transposed: bool| {
            [(false, false), (true, false), (false, true), (true, true)].map(|(across, down)| Self {
                across,
                down,
                transposed,
            })
        };
        let mut symmetries = mirrors(false).to_vec();
        if columns == rows {
            symmetries.extend(mirrors(true));
        }
        symmetries
    }

    /// The cell of the grid that appears at a place of the transformed grid.
    pub(in crate::elastic_depth) fn place(
        self,
        (columns, rows): (usize, usize),
        (column, row): (usize, usize),
    ) -> (usize, usize) {
        let (column, row) = if self.transposed { (row, column) } else { (column, row) };
        (if self.across { columns - 1 - column } else { column }, if self.down { rows - 1 - row } else { row })
    }

    /// The inputs of a cell, transformed.
    pub(in crate::elastic_depth) fn inputs(self, [x, y, slope_x, slope_y, spread]: [f32; INPUTS]) -> [f32; INPUTS] {
        let turned = |is_mirrored: bool, value: f32| if is_mirrored { -value } else { value };
        let [x, slope_x] = [x, slope_x].map(|value| turned(self.across, value));
        let [y, slope_y] = [y, slope_y].map(|value| turned(self.down, value));
        if self.transposed { [y, x, slope_y, slope_x, spread] } else { [x, y, slope_x, slope_y, spread] }
    }
}

use super::LayerError;

/// Square cells that cover a rectangle of the surface about its centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceGrid {
    /// Cells along x.
    pub columns: usize,
    /// Cells along y.
    pub rows: usize,
    /// Side of a cell, mm.
    pub cell_mm: f64,
}

impl SurfaceGrid {
    /// Number of cells.
    #[must_use]
    pub fn len(&self) -> usize {
        self.columns * self.rows
    }

    /// Whether there are no cells.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Area of a cell, mm².
    #[must_use]
    pub fn cell_area_mm2(&self) -> f64 {
        self.cell_mm * self.cell_mm
    }

    /// Centres `(x, y)` of the cells in gel space, mm, row by row.
    pub fn centres_mm(&self) -> impl Iterator<Item = [f64; 2]> + Clone + use<> {
        let Self { columns, rows, cell_mm } = *self;
        let centre = move |index: usize, count: usize| (index as f64 - 0.5 * (count as f64 - 1.0)) * cell_mm;
        (0..rows).flat_map(move |row| (0..columns).map(move |column| [centre(column, columns), centre(row, rows)]))
    }

    pub(super) fn validate(&self) -> Result<(), LayerError> {
        let Self { columns, rows, cell_mm } = *self;
        let is_possible = !self.is_empty() && cell_mm.is_finite() && cell_mm > 0.0;
        if is_possible { Ok(()) } else { Err(LayerError::Grid { columns, rows, cell_mm }) }
    }
}

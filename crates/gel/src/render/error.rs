use thiserror::Error;

/// Why a surface cannot be rendered.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RenderError {
    /// A parameter lies outside its range.
    #[error("{key} is {value}: {allowed} is allowed")]
    OutOfRange {
        /// The parameter, by its key in the `[render]` table.
        key: &'static str,
        /// Its value, in the parameter's own unit.
        value: f64,
        /// The range in words, with its unit.
        allowed: &'static str,
    },
    /// The surface's grid is not valid: its lines must be two or more along each axis, finite and ascending.
    #[error("the surface has {count} grid lines along {axis}: two or more in ascending order are needed")]
    GridLines {
        /// x or y.
        axis: char,
        /// How many there are.
        count: usize,
    },
    /// A field of the surface does not have one value per node of its grid.
    #[error("the surface has {found} values of {field}: its grid of {columns}x{rows} lines has {} nodes", columns * rows)]
    NodeCount {
        /// The field.
        field: &'static str,
        /// Values in it.
        found: usize,
        /// Grid lines along x.
        columns: usize,
        /// Grid lines along y.
        rows: usize,
    },
    /// A node's displacement is not a finite number.
    #[error("the surface's displacement at x = {x_mm} mm, y = {y_mm} mm is not finite")]
    NotFinite {
        /// The node at rest, mm.
        x_mm: f64,
        /// The node at rest, mm.
        y_mm: f64,
    },
    /// The pattern's cells are so small that a table of them would not fit in memory.
    #[error("the pattern has {count:.0} cells on the gel: at most {most:.0} can be drawn, so take larger ones")]
    TooManyCells {
        /// Cells on the gel and close to it.
        count: f64,
        /// The largest number.
        most: f64,
    },
    /// Two states of one motion have different grids.
    #[error("the previous surface has other grid lines than the current one: motion blur needs the same grid for both")]
    OtherGrid,
}

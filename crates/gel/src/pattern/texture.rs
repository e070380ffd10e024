//! A pattern for the renderer: a repeating raster of coloured cells on the gel.

use crate::cells::Cells;
use fingervision_image::Image;

/// Rectangular cells of one colour each, repeated like a torus, that cover the gel's undeformed surface.
///
/// In *cell coordinates* cell `(i, j)` is `[i, i + 1) × [j, j + 1)`. The middle of the raster is at the gel's origin,
/// about which the raster is rotated.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    cells: Image<[f32; 3]>,
    cell_mm: [f64; 2],
    /// Sine and cosine of the rotation of the raster.
    turn: (f64, f64),
}

impl Texture {
    /// A texture of cells with these sides, mm, rotated by an angle clockwise on screen (from x to y), rad.
    ///
    /// # Panics
    ///
    /// If there are no cells.
    #[must_use]
    pub fn new(cells: Image<[f32; 3]>, cell_mm: [f64; 2], rotation_rad: f64) -> Self {
        assert!(!cells.values().is_empty(), "a texture has cells");
        Self { cells, cell_mm, turn: rotation_rad.sin_cos() }
    }

    /// Red, green and blue of all cells, in grey levels.
    #[must_use]
    pub fn cells(&self) -> &Image<[f32; 3]> {
        &self.cells
    }

    /// Sides of a cell, mm.
    #[must_use]
    pub fn cell_mm(&self) -> [f64; 2] {
        self.cell_mm
    }

    /// The place of a point `(x, y)` of the undeformed surface, mm, in cell coordinates.
    #[must_use]
    #[inline]
    pub fn cell_coordinates(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.turn;
        let (columns, rows) = self.cells.size();
        [
            (cos * x + sin * y) / self.cell_mm[0] + 0.5 * columns as f64,
            (cos * y - sin * x) / self.cell_mm[1] + 0.5 * rows as f64,
        ]
    }

    /// Red, green and blue of a cell, in grey levels.
    #[must_use]
    #[inline]
    pub fn at(&self, column: i64, row: i64) -> [f32; 3] {
        let (columns, rows) = self.cells.size();
        self.cells.at(wrapped(column, columns), wrapped(row, rows))
    }
}

impl Cells for Texture {
    #[inline]
    fn at(&self, column: i64, row: i64) -> [f32; 3] {
        self.at(column, row)
    }
}

/// The index on a ring of `len`.
#[inline]
#[expect(clippy::cast_possible_wrap, reason = "a raster has far fewer than 2^63 cells")]
pub(super) fn wrapped(index: i64, len: usize) -> usize {
    index.rem_euclid(len as i64) as usize
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "these places and levels are exact")]
mod tests {
    use super::*;

    fn texture(rotation_rad: f64) -> Texture {
        Texture::new(Image::from_fn(4, 6, |x, y| [x as f32, y as f32, 0.0]), [0.5, 0.25], rotation_rad)
    }

    #[test]
    fn the_middle_of_the_raster_lies_on_the_origin() {
        assert_eq!(texture(0.3).cell_coordinates([0.0, 0.0]), [2.0, 3.0]);
        assert_eq!(texture(0.0).cell_coordinates([-1.0, 0.5]), [0.0, 5.0]);
    }

    #[test]
    fn the_raster_turns_from_x_to_y() {
        // A quarter turn lays the raster's x axis on the gel's y axis.
        let [column, row] = texture(std::f64::consts::FRAC_PI_2).cell_coordinates([0.0, 0.5]);
        assert!((column - 3.0).abs() < 1e-12 && (row - 3.0).abs() < 1e-12, "({column}, {row})");
    }

    #[test]
    fn cells_repeat() {
        assert_eq!(texture(0.0).at(-1, 7), [3.0, 1.0, 0.0]);
    }
}

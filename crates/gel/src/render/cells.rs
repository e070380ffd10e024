//! The pattern's cells as a table of sums, for exact integrals over polygons by their boundaries.
//!
//! By Green's theorem the integral of a colour c over a polygon is the integral of `F dv` around it, with `F(u, v) = ∫ c
//! du` from a fixed column to u. Each cell has one colour, so F is linear in u from line to line: between two grid lines,
//! the midpoint gives the integral exactly. A side that two polygons share is integrated once, and the number of cells
//! that a polygon covers hardly matters.
//!
//! Colours are stored relative to their mean over the pattern, which keeps the sums small enough for single precision.

use super::RenderError;
use crate::Texture;
use crate::polygon::{Point, signed_area};
use fearless_simd::{Simd, f32x4, prelude::*};
use fearless_simd_macros::simd;
use fingervision_image::LUMA_WEIGHTS;

/// Most cells of a table: 400 MB.
const MOST_CELLS: f64 = 25e6;

/// Cells around the gel that are in the table too.
const MARGIN: f64 = 2.0;

/// The colours of all cells on the gel.
#[derive(Debug, Clone)]
pub(crate) struct CellTable {
    /// Its extent at rest: x and y from least to most, mm.
    borders_mm: [[f64; 2]; 2],
    /// u and v by x, y and 1.
    by_mm: [[f64; 3]; 2],
    /// Sums of the columns to the left less their mean, red, green, blue and nothing; a row has one more than cells.
    sums: Vec<[f32; 4]>,
    stride: usize,
    mean: [f32; 3],
}

/// A point in the table's cell coordinates and its cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    pub(crate) u: f32,
    pub(crate) v: f32,
    column: u32,
    row: u32,
}

impl Place {
    /// Beyond the gel's border.
    pub(crate) const BEYOND: Self = Self { u: -1.0, v: -1.0, column: 0, row: 0 };
    /// No surface.
    pub(crate) const NOWHERE: Self = Self { u: -2.0, v: -2.0, column: 0, row: 0 };

    /// A point of the table.
    #[inline(always)]
    pub(crate) fn new(u: f32, v: f32) -> Self {
        // Truncation is the floor: no point of the gel is left of or above the table.
        Self { u, v, column: u as u32, row: v as u32 }
    }

    #[inline(always)]
    pub(crate) fn is_on_gel(&self) -> bool {
        self.u >= 0.0
    }
}

impl CellTable {
    /// The cells between these borders, mm; grey if there is no colour.
    ///
    /// # Errors
    ///
    /// [`RenderError::TooManyCells`] if they are.
    pub(crate) fn new(texture: &Texture, colour: bool, borders_mm: [[f64; 2]; 2]) -> Result<Self, RenderError> {
        let [columns, rows] = reach(texture, borders_mm);
        let count = (columns.1 - columns.0) as f64 * (rows.1 - rows.0) as f64;
        if count > MOST_CELLS {
            return Err(RenderError::TooManyCells { count, most: MOST_CELLS });
        }
        let colour_of = |column, row| {
            let [red, green, blue] = texture.at(column, row);
            let luma = || LUMA_WEIGHTS[0] * red + LUMA_WEIGHTS[1] * green + LUMA_WEIGHTS[2] * blue;
            if colour { [red, green, blue] } else { [luma(); 3] }
        };
        let mean = mean((columns, rows), colour_of);
        let stride = (columns.1 - columns.0 + 1) as usize;
        let mut sums = Vec::with_capacity(stride * (rows.1 - rows.0) as usize);
        for row in rows.0..rows.1 {
            let mut sum = [0.0; 3];
            for column in columns.0..=columns.1 {
                let [red, green, blue] = sum.map(|sum| sum as f32);
                sums.push([red, green, blue, 0.0]);
                for ((sum, level), mean) in sum.iter_mut().zip(colour_of(column, row)).zip(mean) {
                    *sum += f64::from(level) - mean;
                }
            }
        }
        let first = [columns.0 as f64, rows.0 as f64];
        let by_mm = by_mm(texture, first);
        Ok(Self { borders_mm, by_mm, sums, stride, mean: mean.map(|mean| mean as f32) })
    }

    /// The extent of the table at rest, mm.
    pub(crate) fn borders_mm(&self) -> [[f64; 2]; 2] {
        self.borders_mm
    }

    /// u and v by x, y and 1.
    pub(crate) fn by_mm(&self) -> [[f32; 3]; 2] {
        self.by_mm.map(|row| row.map(|value| value as f32))
    }

    /// Colour of a place's cell.
    pub(crate) fn colour(&self, place: Place) -> [f32; 3] {
        let first = place.row as usize * self.stride + place.column as usize;
        let [left, right] = [self.sums[first], self.sums[first + 1]];
        std::array::from_fn(|channel| self.mean[channel] + (right[channel] - left[channel]))
    }

    /// `∫ F dv` from a place to another, both on the gel.
    #[inline(always)]
    pub(crate) fn along<S: Simd>(&self, simd: S, from: &Place, to: &Place) -> f32x4<S> {
        if from.column == to.column && from.row == to.row {
            self.piece(simd, from.column, from.row, 0.5 * (from.u + to.u), to.v - from.v)
        } else {
            self.walk(simd, from, to)
        }
    }

    /// Mean colour over a polygon from its integral and its area in cells.
    #[inline(always)]
    pub(crate) fn mean_colour<S: Simd>(&self, simd: S, integral: f32x4<S>, area: f32) -> f32x4<S> {
        let [red, green, blue] = self.mean;
        integral * area.recip() + f32x4::load_array(simd, [red, green, blue, 0.0])
    }

    /// Mean colour over a polygon of points at rest, mm, all on the gel.
    pub(crate) fn mean_colour_within<S: Simd>(
        &self,
        simd: S,
        polygon_mm: &[Point],
        cells: &mut Vec<Point>,
    ) -> f32x4<S> {
        let [u, v] = self.by_mm;
        cells.clear();
        cells.extend(polygon_mm.iter().map(|&[x, y]| [u, v].map(|row| row[0] * x + row[1] * y + row[2])));
        let place = |point: Point| Place::new(point[0] as f32, point[1] as f32);
        let mut integral = f32x4::splat(simd, 0.0);
        for (k, &point) in cells.iter().enumerate() {
            let next = cells[(k + 1) % cells.len()];
            integral += self.along(simd, &place(point), &place(next));
        }
        self.mean_colour(simd, integral, signed_area(cells) as f32)
    }

    #[inline(always)]
    fn piece<S: Simd>(&self, simd: S, column: u32, row: u32, u: f32, dv: f32) -> f32x4<S> {
        let sums = &self.sums[row as usize * self.stride + column as usize..][..2];
        let (left, right) = (f32x4::load_array(simd, sums[0]), f32x4::load_array(simd, sums[1]));
        ((right - left) * (u - column as f32) + left) * dv
    }

    /// The side from place to place, cut at every grid line that it crosses.
    #[simd]
    fn walk<S: Simd>(&self, simd: S, from: &Place, to: &Place) -> f32x4<S> {
        let mut total = f32x4::splat(simd, 0.0);
        if !(from.is_on_gel() && to.is_on_gel()) {
            return total;
        }
        let (du, dv) = (to.u - from.u, to.v - from.v);
        let mut across = Crossings::new(from.u, du, from.column, to.column);
        let mut down = Crossings::new(from.v, dv, from.row, to.row);
        let mut passed = 0.0;
        loop {
            let (column, row) = (across.cell, down.cell);
            let next = if across.next <= down.next { across.step() } else { down.step() }.clamp(passed, 1.0);
            total += self.piece(simd, column, row, from.u + du * 0.5 * (passed + next), dv * (next - passed));
            if (column, row) == (to.column, to.row) {
                return total;
            }
            passed = next;
        }
    }
}

/// The grid lines that a side crosses along one axis.
struct Crossings {
    cell: u32,
    left: u32,
    is_forward: bool,
    /// Fraction of the side up to the next line; infinite after the last.
    next: f32,
    step: f32,
}

impl Crossings {
    #[inline(always)]
    fn new(from: f32, way: f32, cell: u32, last: u32) -> Self {
        let left = cell.abs_diff(last);
        let is_forward = last > cell;
        let line = cell + u32::from(is_forward);
        let next = if left == 0 { f32::INFINITY } else { (line as f32 - from) / way };
        Self { cell, left, is_forward, next, step: way.abs().recip() }
    }

    /// Moves to the next cell; returns the fraction of the side before it.
    #[inline(always)]
    fn step(&mut self) -> f32 {
        let passed = self.next;
        if self.left > 0 {
            self.left -= 1;
            self.cell = if self.is_forward { self.cell + 1 } else { self.cell - 1 };
            self.next = if self.left == 0 { f32::INFINITY } else { self.next + self.step };
        }
        passed
    }
}

/// The columns and rows of cells between borders, mm, and around them, without the ends.
fn reach(texture: &Texture, [[left, right], [top, bottom]]: [[f64; 2]; 2]) -> [(i64, i64); 2] {
    let corners = [[left, top], [right, top], [left, bottom], [right, bottom]].map(|p| texture.cell_coordinates(p));
    [0, 1].map(|axis| {
        let [a, b, c, d] = corners.map(|corner| corner[axis]);
        let first = a.min(b).min(c.min(d)) - MARGIN;
        (first.floor() as i64, (a.max(b).max(c.max(d)) + MARGIN).ceil() as i64)
    })
}

/// Mean colour of the cells from column to column and row to row.
fn mean(
    ((left, right), (top, bottom)): ((i64, i64), (i64, i64)),
    colour_of: impl Fn(i64, i64) -> [f32; 3],
) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (column, row) in (top..bottom).flat_map(|row| (left..right).map(move |column| (column, row))) {
        for (sum, level) in sum.iter_mut().zip(colour_of(column, row)) {
            *sum += f64::from(level);
        }
    }
    sum.map(|sum| sum / ((right - left) * (bottom - top)) as f64)
}

/// u and v by x, y and 1, counted from the cell `first`.
fn by_mm(texture: &Texture, first: [f64; 2]) -> [[f64; 3]; 2] {
    let [origin, along_x, along_y] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|p| texture.cell_coordinates(p));
    [0, 1].map(|axis| [along_x[axis] - origin[axis], along_y[axis] - origin[axis], origin[axis] - first[axis]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coverage::mean_colours;
    use fearless_simd::{Level, dispatch};
    use fingervision_image::Image;

    #[test]
    fn integrals_around_equal_the_cut_cells() {
        let level = |x: usize, y: usize, k: usize| ((31 * x + 17 * y + 7 * k + x * y) % 251) as f32;
        let cells = Image::from_fn(40, 30, |x, y| [0, 1, 2].map(|k| level(x, y, k)));
        let texture = Texture::new(cells, [0.1, 0.07], 0.3);
        let table = CellTable::new(&texture, true, [[-15.0, 15.0], [-12.0, 12.0]]).unwrap();
        let mut scratch = Vec::new();
        // Quadrilaterals of a third of a cell and of several, at the far corner of the gel.
        for size_mm in [0.03, 0.4] {
            let corners = Image::from_fn(21, 16, |x, y| {
                let (x, y) = (x as f64, y as f64);
                let bent = [x + 0.2 * (0.9 * y).sin() - 20.0, y + 0.2 * (0.7 * x).cos() - 16.0];
                [14.9 + size_mm * bent[0], 11.9 + size_mm * bent[1]]
            });
            let in_cells = Image::from_fn(21, 16, |x, y| texture.cell_coordinates(corners.at(x, y)));
            let expected = mean_colours(&in_cells, &texture);
            for (x, y) in (0..20).flat_map(|x| (0..15).map(move |y| (x, y))) {
                let quad = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)].map(|(x, y)| corners.at(x, y));
                let colour =
                    dispatch!(Level::new(), simd => table.mean_colour_within(simd, &quad, &mut scratch).to_array());
                for (level, expected) in colour.iter().zip(expected.at(x, y)) {
                    assert!((level - expected).abs() < 0.05, "{size_mm} mm, ({x}, {y}): {level}, cut {expected}");
                }
            }
        }
    }

    #[test]
    fn a_place_has_the_colour_of_its_cell() {
        let cells = Image::from_fn(3, 2, |x, y| [10.0 * x as f32, 100.0 * y as f32, 7.0]);
        let texture = Texture::new(cells, [1.0; 2], 0.0);
        let table = CellTable::new(&texture, true, [[-1.5, 1.5], [-1.0, 1.0]]).unwrap();
        let [u, v] = table.by_mm();
        let place = |x: f32, y: f32| Place::new(u[0] * x + u[1] * y + u[2], v[0] * x + v[1] * y + v[2]);
        for (x, y, expected) in
            [(-1.4, -0.9, [0.0, 0.0, 7.0]), (0.0, 0.1, [10.0, 100.0, 7.0]), (1.4, -0.1, [20.0, 0.0, 7.0])]
        {
            for (level, expected) in table.colour(place(x, y)).iter().zip(expected) {
                assert!((level - expected).abs() < 1e-4, "({x}, {y}): {level}, {expected}");
            }
        }
    }
}

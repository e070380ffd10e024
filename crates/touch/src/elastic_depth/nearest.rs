//! The nearest marked cell of every cell of a grid.

use fearless_simd::{Level, dispatch, f32x8, prelude::*};
use fearless_simd_macros::simd;

/// Cells that are processed together.
const LANES: usize = 8;
/// The lanes' numbers.
const LANE: [f32; LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
/// The row that is given where no cell is marked. It lies farther away than any cell of the grid.
const NOWHERE: f32 = -20_000.0;

/// Finds the nearest marked cells. Owns its memory.
///
/// First every cell takes the nearest marked cell of its column, then the nearest of those that the cells of its row have
/// ([Saito1994]). This is exact; of cells that are equally near, any may be found.
#[derive(Debug, Clone)]
pub(super) struct Nearest {
    level: Level,
    columns: usize,
    /// Columns, rounded up to whole registers.
    stride: usize,
    /// Column and row of the nearest marked cell, row by row of the grid.
    column: Vec<f32>,
    row: Vec<f32>,
    /// For the cells of a row the row of the nearest marked cell of their column, and its squared distance.
    row_of_column: Vec<f32>,
    squared: Vec<f32>,
}

impl Nearest {
    /// For a grid of this many columns and rows; no cell is marked.
    pub(super) fn new((columns, rows): (usize, usize)) -> Self {
        let stride = columns.next_multiple_of(LANES);
        Self {
            level: Level::new(),
            columns,
            stride,
            column: vec![0.0; stride * rows],
            row: vec![NOWHERE; stride * rows],
            row_of_column: vec![0.0; stride],
            squared: vec![0.0; stride],
        }
    }

    /// Finds the nearest marked cell of every cell.
    ///
    /// # Panics
    ///
    /// If there are not as many marks as cells.
    pub(super) fn find(&mut self, marks: &[bool]) {
        assert_eq!(marks.len(), self.columns * (self.row.len() / self.stride), "marks of the cells");
        dispatch!(self.level, simd => self.fill(simd, marks));
    }

    /// Whether any cell is marked.
    pub(super) fn is_any(&self) -> bool {
        self.row[0] >= 0.0
    }

    /// The nearest marked cell of a cell: itself if it is marked.
    pub(super) fn of(&self, cell: usize) -> Option<usize> {
        let place = self.place(cell);
        // Small integers.
        self.is_any().then(|| self.row[place] as usize * self.columns + self.column[place] as usize)
    }

    /// The distance of a cell from the nearest marked one, in cells; very large if no cell is marked.
    pub(super) fn distance(&self, cell: usize) -> f64 {
        let place = self.place(cell);
        let [x, y] =
            [self.column[place] - (cell % self.columns) as f32, self.row[place] - (cell / self.columns) as f32];
        f64::from(x * x + y * y).sqrt()
    }

    fn place(&self, cell: usize) -> usize {
        cell / self.columns * self.stride + cell % self.columns
    }

    #[simd]
    fn fill<S: Simd>(&mut self, simd: S, marks: &[bool]) {
        let Self { columns, stride, column, row, row_of_column, squared, .. } = self;
        let (columns, stride) = (*columns, *stride);
        let count = row.len() / stride;
        row_of_column.fill(NOWHERE);
        for (y, (rows, marks)) in row.chunks_exact_mut(stride).zip(marks.chunks_exact(columns)).enumerate() {
            for ((row, above), &mark) in rows.iter_mut().zip(row_of_column.iter_mut()).zip(marks) {
                *above = if mark { y as f32 } else { *above };
                *row = *above;
            }
        }
        for y in (0..count - 1).rev() {
            let (here, below) = row[y * stride..(y + 2) * stride].split_at_mut(stride);
            for (here, below) in here.iter_mut().zip(below) {
                let is_below = (*below - y as f32).abs() < (*here - y as f32).abs();
                *here = if is_below { *below } else { *here };
            }
        }
        for (y, (rows, found)) in row.chunks_exact_mut(stride).zip(column.chunks_exact_mut(stride)).enumerate() {
            row_of_column.copy_from_slice(rows);
            for (squared, row) in squared.iter_mut().zip(&*rows) {
                *squared = (row - y as f32) * (row - y as f32);
            }
            let blocks = rows.as_chunks_mut::<LANES>().0.iter_mut().zip(found.as_chunks_mut::<LANES>().0);
            for (block, (rows, found)) in blocks.enumerate() {
                let first = block * LANES;
                let places = f32x8::from_slice(simd, &LANE) + first as f32;
                let mut best = f32x8::from_slice(simd, &squared[first..][..LANES]);
                let [mut best_column, mut best_row] = [places, f32x8::load_array_ref(simd, rows)];
                if !best.simd_le(0.0).all_true() {
                    for (other, (&squared, &row)) in squared[..columns].iter().zip(&*row_of_column).enumerate() {
                        let away = places - other as f32;
                        let distance = away.mul_add(away, f32x8::splat(simd, squared));
                        let is_nearer = distance.simd_lt(best);
                        best = is_nearer.select(distance, best);
                        best_column = is_nearer.select(f32x8::splat(simd, other as f32), best_column);
                        best_row = is_nearer.select(f32x8::splat(simd, row), best_row);
                    }
                }
                best_column.store_array(found);
                best_row.store_array(rows);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distance(columns: usize, from: usize, to: usize) -> f64 {
        let [x, y] = [(from % columns).abs_diff(to % columns), (from / columns).abs_diff(to / columns)];
        ((x * x + y * y) as f64).sqrt()
    }

    #[test]
    fn the_nearest_mark_is_found() {
        for (columns, rows) in [(37, 29), (16, 3), (5, 40)] {
            let mut nearest = Nearest::new((columns, rows));
            for seed in 1..5 {
                let mut marks: Vec<_> =
                    (0..columns * rows).map(|cell| (cell * cell * seed) % 53 == 1 && cell % columns > 2).collect();
                marks[columns + 1] = true;
                nearest.find(&marks);
                for cell in 0..marks.len() {
                    let found = nearest.of(cell).unwrap();
                    let marked = (0..marks.len()).filter(|&other| marks[other]);
                    let least = marked.map(|other| distance(columns, cell, other)).fold(f64::INFINITY, f64::min);
                    assert!(marks[found]);
                    assert!((distance(columns, cell, found) - least).abs() < 1e-6, "cell {cell}: {found}");
                    assert!((nearest.distance(cell) - least).abs() < 1e-6, "cell {cell}");
                }
            }
        }
    }

    #[test]
    fn without_a_mark_there_is_no_nearest() {
        let mut nearest = Nearest::new((4, 3));
        nearest.find(&[true; 12]);
        nearest.find(&[false; 12]);
        assert!(!nearest.is_any() && (0..12).all(|cell| nearest.of(cell).is_none() && nearest.distance(cell) > 1e4));
    }
}

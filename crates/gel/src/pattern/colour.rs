//! The dense random colour pattern.
//!
//! Every cell's colour is random, and differs from its eight neighbours by at least [`NEIGHBOUR_DISTANCE`] in RGB, so
//! that every cell edge is visible (Du, Zhang, Zhang, Wang 2021, doi 10.1109/LRA.2021.3061306). The pattern repeats like
//! a torus, and the rule also holds across the seam: it has no border.

use super::texture::wrapped;
use crate::GelError;
use crate::cells::Cells;
use fingervision_image::Image;
use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// Least Euclidean distance in RGB between a cell and each of its eight neighbours, in grey levels.
pub const NEIGHBOUR_DISTANCE: f32 = 30.0;

/// Fewest levels between darkest and brightest that always leave a colour: eight balls of radius 30 fill a cube of 97.
const LEAST_SPAN: u8 = 100;

/// A torus of coloured square cells; cell `(i, j)` is `[i, i + 1) × [j, j + 1)` in cell coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct ColourPattern {
    cells: Image<[f32; 3]>,
}

impl ColourPattern {
    /// A pattern of `columns · rows` cells whose channels are whole numbers, uniform over `levels` (darkest and
    /// brightest grey level, both included). The same seed gives the same pattern.
    ///
    /// # Errors
    ///
    /// [`GelError::OutOfRange`] if there are fewer than three columns or rows, or `levels` span less than 100.
    pub fn random(columns: usize, rows: usize, levels: [u8; 2], seed: u64) -> Result<Self, GelError> {
        let out_of_range = |name, value, allowed| Err(GelError::OutOfRange { name, value, allowed });
        if columns.min(rows) < 3 {
            return out_of_range("cells across the pattern", columns.min(rows) as f64, "3 or more");
        }
        let span = levels[1].saturating_sub(levels[0]);
        let Some(channel) = Uniform::new_inclusive(levels[0], levels[1]).ok().filter(|_| span >= LEAST_SPAN) else {
            return out_of_range("span of the pattern's levels", f64::from(span), "100 grey levels or more");
        };
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let mut cells = Image::filled(columns, rows, None);
        for row in 0..rows {
            for column in 0..columns {
                let colour = distinct_colour(&cells, column, row, channel, &mut rng);
                cells.row_mut(row)[column] = Some(colour);
            }
        }
        let cells = Image::from_fn(columns, rows, |column, row| cells.at(column, row).unwrap_or_default());
        Ok(Self { cells })
    }

    /// Columns and rows after which the pattern repeats, in cells.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        self.cells.size()
    }

    /// All cells: red, green and blue, in grey levels.
    pub(super) fn into_cells(self) -> Image<[f32; 3]> {
        self.cells
    }

    /// Red, green and blue of a cell, in grey levels.
    #[must_use]
    pub fn at(&self, column: i64, row: i64) -> [f32; 3] {
        let (columns, rows) = self.cells.size();
        self.cells.at(wrapped(column, columns), wrapped(row, rows))
    }
}

impl Cells for ColourPattern {
    #[inline]
    fn at(&self, column: i64, row: i64) -> [f32; 3] {
        self.at(column, row)
    }
}

/// Draws colours until one differs enough from every neighbour that has one.
fn distinct_colour(
    cells: &Image<Option<[f32; 3]>>,
    column: usize,
    row: usize,
    channel: Uniform<u8>,
    rng: &mut impl Rng,
) -> [f32; 3] {
    let (columns, rows) = cells.size();
    loop {
        let colour = [(); 3].map(|()| f32::from(channel.sample(rng)));
        let mut neighbours = (0..9).filter_map(|k| {
            // Adding all except one of the torus' columns is one step back.
            let x = (column + columns - 1 + k % 3) % columns;
            let y = (row + rows - 1 + k / 3) % rows;
            cells.at(x, y)
        });
        if neighbours.all(|neighbour| distance(colour, neighbour) >= NEIGHBOUR_DISTANCE) {
            return colour;
        }
    }
}

fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_differ_by_thirty_across_the_seam_too() {
        let pattern = ColourPattern::random(40, 25, [16, 240], 7).unwrap();
        for row in 0..25 {
            for column in 0..40 {
                for (right, down) in [(1, 0), (0, 1), (1, 1), (-1, 1)] {
                    let (a, b) = (pattern.at(column, row), pattern.at(column + right, row + down));
                    assert!(distance(a, b) >= 30.0, "cells at ({column}, {row}) and ({right}, {down}) from it");
                }
            }
        }
    }

    #[test]
    fn colours_fill_their_range_evenly() {
        let pattern = ColourPattern::random(100, 100, [16, 240], 3).unwrap();
        let channels = || pattern.cells.values().iter().flatten().copied();
        assert!(channels().all(|level| (16.0..=240.0).contains(&level)));
        let mean = channels().sum::<f32>() / 30_000.0;
        let variance = channels().map(|level| (level - mean).powi(2)).sum::<f32>() / 30_000.0;
        assert!((mean - 128.0).abs() < 2.0, "mean {mean}");
        // The rule for neighbours hardly changes the (225² − 1) / 12 of the uniform distribution.
        assert!((variance.sqrt() - 65.0).abs() < 2.0, "standard deviation {}", variance.sqrt());
    }

    #[test]
    fn a_seed_names_a_pattern() {
        let pattern = |seed| ColourPattern::random(9, 8, [0, 255], seed).unwrap();
        assert_eq!(pattern(5), pattern(5));
        assert_ne!(pattern(5), pattern(6));
    }

    #[test]
    fn a_span_that_might_leave_no_colour_is_refused() {
        let error = ColourPattern::random(9, 8, [100, 180], 1).unwrap_err();
        assert_eq!(error.to_string(), "span of the pattern's levels is 80: 100 grey levels or more is allowed");
        assert!(ColourPattern::random(9, 8, [240, 16], 1).is_err());
        assert!(ColourPattern::random(2, 8, [0, 255], 1).is_err());
    }
}

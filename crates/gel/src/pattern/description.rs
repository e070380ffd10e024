//! The description of a pattern: the `[pattern]` table of a scene, and the options for printing.

use std::fmt::Display;

use super::{ColourPattern, PatternError, Texture, discs};
use fingervision_image::Image;

/// Most cells of a colour pattern along a side.
const MOST_CELLS: usize = 4096;

/// A pattern and its placement on the gel.
///
/// As a table: `kind` is `"colour"`, `"dots"` or `"speckle"`; `cell_mm` belongs to the first, `dots` and
/// `dot_diameter_mm` to the second, `speckle_diameter_mm` and `coverage` to the third. Keys left out take the default; a
/// key of another kind is refused.
#[derive(Debug, Clone, PartialEq)]
pub struct Pattern {
    /// The repeated element.
    pub motif: Motif,
    /// Darkest and brightest grey level. Colours are uniform between them; dots and speckles are dark on bright.
    pub levels: [u8; 2],
    /// The seed: the same seed gives the same cells or speckles. A grid of dots is not random.
    pub seed: u64,
    /// Angle by which the pattern lies turned on the gel, clockwise on screen, rad.
    pub rotation_rad: f64,
}

/// The elements of a pattern.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motif {
    /// Dense random colours; see [`ColourPattern`].
    Colour {
        /// Side of a cell, mm.
        cell_mm: f64,
    },
    /// An even grid of dots.
    Dots {
        /// Columns and rows of dots.
        count: [usize; 2],
        /// Diameter of a dot, mm.
        diameter_mm: f64,
    },
    /// Random discs, as digital image correlation uses them.
    Speckle {
        /// Mean diameter, mm; a disc's own is up to a quarter smaller or larger.
        diameter_mm: f64,
        /// Part of the area that they cover, 0.05 to 0.9.
        coverage: f64,
    },
}

impl Motif {
    /// Default side of a colour cell, mm.
    pub const CELL_MM: f64 = 0.1;
    /// Default columns and rows of dots.
    pub const DOTS: [usize; 2] = [15, 15];
    /// Default diameter of a dot, mm.
    pub const DOT_DIAMETER_MM: f64 = 1.0;
    /// Default mean diameter of a speckle, mm.
    pub const SPECKLE_DIAMETER_MM: f64 = 0.25;
    /// Default part of the area that speckles cover, dimensionless.
    pub const COVERAGE: f64 = 0.5;
}

impl Default for Pattern {
    fn default() -> Self {
        Self {
            motif: Motif::Colour { cell_mm: Motif::CELL_MM },
            levels: [16, 240],
            seed: 1,
            rotation_rad: 1.5_f64.to_radians(),
        }
    }
}

impl Pattern {
    /// Checks every value's range.
    ///
    /// # Errors
    ///
    /// [`PatternError::OutOfRange`] naming the first value that is outside.
    pub fn validate(&self) -> Result<(), PatternError> {
        let length = "a length of 0.001 to 1000 mm";
        let is_length = |value: f64| (0.001..=1000.0).contains(&value);
        match self.motif {
            Motif::Colour { cell_mm } => check(is_length(cell_mm), "cell_mm", &cell_mm, length)?,
            Motif::Dots { count, diameter_mm } => {
                let is_count = count.into_iter().all(|count| (1..=1000).contains(&count));
                check(is_count, "dots", &format!("{count:?}"), "columns and rows of 1 to 1000 dots")?;
                check(is_length(diameter_mm), "dot_diameter_mm", &diameter_mm, length)?;
            }
            Motif::Speckle { diameter_mm, coverage } => {
                check(is_length(diameter_mm), "speckle_diameter_mm", &diameter_mm, length)?;
                check((0.05..=0.9).contains(&coverage), "coverage", &coverage, "0.05 to 0.9")?;
            }
        }
        let levels = "the darkest and the brightest grey level, in this order";
        check(self.levels[0] < self.levels[1], "levels", &format!("{:?}", self.levels), levels)?;
        check(self.rotation_rad.is_finite(), "rotation_rad", &self.rotation_rad, "a finite angle, rad")
    }

    /// The pattern on an undeformed gel of this size, mm, for the renderer. It is centred and repeats beyond the size.
    ///
    /// The cells of a colour pattern are those of the print with the same seed and size. Discs become a raster of 24
    /// cells per (mean) diameter, fewer if there are many, each with the part of it that they cover.
    ///
    /// # Errors
    ///
    /// The errors of [`Pattern::validate`], [`PatternError::DotsOverlap`], or [`PatternError::Count`] if the parts are
    /// too fine or too coarse for the size.
    pub fn texture(&self, size_mm: [f64; 2]) -> Result<Texture, PatternError> {
        self.check_size(size_mm)?;
        let ground = match self.motif {
            Motif::Colour { cell_mm } => {
                let cells = self.colours(size_mm)?.into_cells();
                return Ok(Texture::new(cells, [cell_mm; 2], self.rotation_rad));
            }
            Motif::Dots { count, diameter_mm } => discs::dot_tile(count, diameter_mm, size_mm)?,
            Motif::Speckle { diameter_mm, coverage } => discs::speckle(diameter_mm, coverage, size_mm, self.seed)?.1,
        };
        let grey = ground.grey(f64::from(self.levels[0]), f64::from(self.levels[1]));
        let cells = Image::from_fn(grey.width(), grey.height(), |x, y| [grey.at(x, y); 3]);
        Ok(Texture::new(cells, ground.cell_mm(), self.rotation_rad))
    }

    /// The colour cells that fill a size, to the nearest whole cell.
    pub(super) fn colours(&self, size_mm: [f64; 2]) -> Result<ColourPattern, PatternError> {
        let [columns, rows] = self.whole_cells(size_mm)?;
        Ok(ColourPattern::random(columns, rows, self.levels, self.seed)?)
    }

    /// The columns and rows of cells that fit a size best.
    fn whole_cells(&self, size_mm: [f64; 2]) -> Result<[usize; 2], PatternError> {
        let Motif::Colour { cell_mm } = self.motif else { return Ok([1, 1]) };
        let counts = size_mm.map(|size| (size / cell_mm).round());
        for (size_mm, count) in size_mm.into_iter().zip(counts) {
            if !(3.0..=MOST_CELLS as f64).contains(&count) {
                return Err(PatternError::Count { what: "cells", size_mm, part_mm: cell_mm, count, most: MOST_CELLS });
            }
        }
        Ok(counts.map(|count| count as usize))
    }

    /// Checks the pattern and whether it can have this size.
    pub(super) fn check_size(&self, size_mm: [f64; 2]) -> Result<(), PatternError> {
        self.validate()?;
        let is_size = size_mm.into_iter().all(|size| (0.01..=1000.0).contains(&size));
        check(is_size, "size_mm", &format!("{size_mm:?}"), "a width and a height of 0.01 to 1000 mm")?;
        let Motif::Dots { count, diameter_mm } = self.motif else { return Ok(()) };
        let [across, down] = discs::pitch_mm(count, size_mm);
        let pitch_mm = across.min(down);
        if diameter_mm < pitch_mm {
            Ok(())
        } else {
            Err(PatternError::DotsOverlap { diameter_mm, count, size_mm, pitch_mm })
        }
    }
}

fn check(holds: bool, key: &'static str, value: &dyn Display, allowed: &'static str) -> Result<(), PatternError> {
    if holds { Ok(()) } else { Err(PatternError::OutOfRange { key, value: value.to_string(), allowed }) }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "levels and sides are handed over as they are")]
mod tests {
    use super::*;

    const SIZE_MM: [f64; 2] = [6.0, 4.0];

    fn pattern(motif: Motif) -> Pattern {
        Pattern { motif, ..Pattern::default() }
    }

    fn refusal(motif: Motif) -> String {
        pattern(motif).texture(SIZE_MM).unwrap_err().to_string()
    }

    #[test]
    fn colour_cells_fill_the_size() {
        let texture = Pattern::default().texture(SIZE_MM).unwrap();
        let expected = ColourPattern::random(60, 40, [16, 240], 1).unwrap();
        assert_eq!(texture.cell_mm(), [0.1, 0.1]);
        assert_eq!(texture.cells(), &expected.into_cells());
    }

    #[test]
    fn the_middle_of_odd_dots_is_dark_and_of_even_dots_bright() {
        for (count, expected) in [([3, 3], 16.0), ([4, 4], 240.0), ([3, 4], 240.0)] {
            let texture = pattern(Motif::Dots { count, diameter_mm: 0.5 }).texture(SIZE_MM).unwrap();
            let [column, row] = texture.cell_coordinates([0.01, 0.01]);
            let level = texture.at(column.floor() as i64, row.floor() as i64);
            assert_eq!(level, [expected; 3], "{count:?}");
        }
    }

    #[test]
    fn dots_stand_where_the_print_has_them() {
        let texture = pattern(Motif::Dots { count: [6, 2], diameter_mm: 0.5 });
        let texture = Pattern { rotation_rad: 0.0, ..texture }.texture(SIZE_MM).unwrap();
        for disc in discs::dots([6, 2], 0.5, SIZE_MM) {
            let [x, y] = disc.centre_mm;
            let [column, row] = texture.cell_coordinates([x - 3.0, y - 2.0]);
            assert_eq!(texture.at(column.floor() as i64, row.floor() as i64), [16.0; 3], "({x}, {y}) mm");
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        for cell_mm in [0.0, -1.0, f64::NAN] {
            assert!(refusal(Motif::Colour { cell_mm }).starts_with(&format!("cell_mm = {cell_mm} is impossible")));
        }
        assert!(refusal(Motif::Colour { cell_mm: 0.001 }).contains("6000 across: 3 to 4096"));
        assert!(refusal(Motif::Colour { cell_mm: 2.0 }).contains("4 mm with cells of 2 mm has 2 across"));
        let error = pattern(Motif::Dots { count: [6, 2], diameter_mm: 1.0 }).texture(SIZE_MM).unwrap_err();
        assert_eq!(error.to_string(), "dots of 1 mm overlap: 6 by 2 of them on 6x4 mm stand 1.0000 mm apart");
        assert!(error.hint().contains("below 1.0000 mm"));
        assert!(refusal(Motif::Dots { count: [0, 2], diameter_mm: 1.0 }).starts_with("dots = [0, 2]"));
        assert!(refusal(Motif::Speckle { diameter_mm: 0.2, coverage: 1.0 }).starts_with("coverage = 1"));
        let levels = Pattern { levels: [200, 100], ..Pattern::default() }.validate().unwrap_err();
        assert!(levels.to_string().starts_with("levels = [200, 100]"));
    }
}

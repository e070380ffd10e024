//! The requested pattern.

use fingervision_gel::{Motif, Pattern};

use super::pair;
use crate::failure::Failure;
use crate::whole_number::whole_number;

#[derive(Debug, clap::Args)]
pub(super) struct PatternArgs {
    /// Kind of pattern
    #[arg(long, value_enum, default_value_t = Kind::Colour)]
    pub(super) kind: Kind,
    /// Width and height of the pattern, mm, rounded to a whole number of cells; without it 30,30, or the gel's size in
    /// a score
    #[arg(long, value_name = "W,H", value_parser = size)]
    pub(super) size_mm: Option<[f64; 2]>,
    /// Side of a colour cell, mm [default: 0.1]
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    pub(super) cell_mm: Option<f64>,
    /// Columns and rows of dots [default: 15,15]
    #[arg(long, value_name = "N,M", value_parser = dots)]
    dots: Option<[usize; 2]>,
    /// Diameter of a dot, mm; without it half the distance between dots
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    pub(super) dot_diameter_mm: Option<f64>,
    /// Mean diameter of a speckle, mm [default: 0.25]
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    pub(super) speckle_diameter_mm: Option<f64>,
    /// Part of the area that speckles cover, 0.05 to 0.9 [default: 0.5]
    #[arg(long, value_name = "PART", allow_negative_numbers = true)]
    coverage: Option<f64>,
    /// Seed of the cells or speckles: the same seed gives the same pattern
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole_number::<u64>)]
    seed: u64,
    /// Darkest and brightest grey level; without it 0,255 on paper, 16,240 in the score's camera image
    #[arg(long, value_name = "LO,HI", value_parser = levels)]
    levels: Option<[u8; 2]>,
}

/// The values of `--kind`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Kind {
    /// Dense random colours: every cell at least 30 apart in RGB from its eight neighbours
    Colour,
    /// Black dots on white, evenly spaced
    Dots,
    /// Random black discs on white, as digital image correlation uses them
    Speckle,
}

impl Kind {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Colour => "colour",
            Self::Dots => "dots",
            Self::Speckle => "speckle",
        }
    }
}

impl PatternArgs {
    /// The pattern on a surface of this size, with these levels unless others were given.
    pub(super) fn pattern(&self, size_mm: [f64; 2], levels: [u8; 2]) -> Result<Pattern, Failure> {
        self.check_kind()?;
        let motif = match self.kind {
            Kind::Colour => Motif::Colour { cell_mm: self.cell_mm.unwrap_or(Motif::CELL_MM) },
            Kind::Dots => {
                let count = self.dots.unwrap_or(Motif::DOTS);
                let pitch_mm = (size_mm[0] / count[0] as f64).min(size_mm[1] / count[1] as f64);
                Motif::Dots { count, diameter_mm: self.dot_diameter_mm.unwrap_or(0.5 * pitch_mm) }
            }
            Kind::Speckle => Motif::Speckle {
                diameter_mm: self.speckle_diameter_mm.unwrap_or(Motif::SPECKLE_DIAMETER_MM),
                coverage: self.coverage.unwrap_or(Motif::COVERAGE),
            },
        };
        let pattern = Pattern { motif, levels: self.levels.unwrap_or(levels), seed: self.seed, ..Pattern::default() };
        pattern.validate()?;
        Ok(pattern)
    }

    /// Refuses options of another kind.
    fn check_kind(&self) -> Result<(), Failure> {
        let options = [
            ("--cell-mm", self.cell_mm.is_some(), Kind::Colour),
            ("--dots", self.dots.is_some(), Kind::Dots),
            ("--dot-diameter-mm", self.dot_diameter_mm.is_some(), Kind::Dots),
            ("--speckle-diameter-mm", self.speckle_diameter_mm.is_some(), Kind::Speckle),
            ("--coverage", self.coverage.is_some(), Kind::Speckle),
        ];
        let Some((option, _, owner)) = options.into_iter().find(|&(_, is_given, owner)| is_given && owner != self.kind)
        else {
            return Ok(());
        };
        Err(Failure::new(
            format!("{option} is for --kind {}, not for {}", owner.name(), self.kind.name()),
            format!("use --kind {} or leave {option} out", owner.name()),
        ))
    }
}

fn size(text: &str) -> Result<[f64; 2], String> {
    let size: [f64; 2] = pair(text, "30,30")?;
    let is_size = size.into_iter().all(|side| side.is_finite() && side > 0.0);
    if is_size { Ok(size) } else { Err("a width and a height are lengths above 0 mm".into()) }
}

fn dots(text: &str) -> Result<[usize; 2], String> {
    let count: [usize; 2] = pair(text, "15,15")?;
    if count.contains(&0) { Err("there is at least one column and one row".into()) } else { Ok(count) }
}

fn levels(text: &str) -> Result<[u8; 2], String> {
    pair(text, "0,255").map_err(|error| format!("{error}, each 0 to 255"))
}

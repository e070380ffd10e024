//! A pattern on paper at true scale: PDF, SVG and PNG.
//!
//! Around the pattern are crop marks, a scale bar of 10 mm to check the printer with, and a caption with everything
//! needed to make the same pattern again. Nothing in a file depends on time, machine or typefaces: the same pattern
//! gives the same bytes.

mod lettering;
mod page;
mod paper;
mod pdf;
mod png;
mod stroke;
mod svg;

use fingervision_image::Image;

use super::{Motif, Pattern, PatternError, discs};
use page::{Artwork, Page};
pub use paper::Paper;

/// A pattern laid out on a page.
#[derive(Debug, Clone)]
pub struct Print {
    page: Page,
    /// Side of a colour cell, mm; absent where the pattern has none.
    cell_mm: Option<f64>,
}

impl Print {
    /// Lays out a pattern of this width and height, mm. A colour pattern takes the nearest whole number of cells; see
    /// [`Print::pattern_mm`]. It is not turned: that is how a print is put on a gel.
    ///
    /// # Errors
    ///
    /// As [`Pattern::texture`].
    pub fn new(pattern: &Pattern, size_mm: [f64; 2]) -> Result<Self, PatternError> {
        let Parts { pattern_mm, artwork, facts, cell_mm } = Parts::of(pattern, size_mm)?;
        Ok(Self { page: Page::around(pattern_mm, artwork, &facts), cell_mm })
    }

    /// The same in the middle of a sheet of paper, in landscape if the pattern is too wide for portrait.
    ///
    /// # Errors
    ///
    /// As [`Print::new`], and [`PatternError::Paper`] if the pattern does not fit.
    pub fn on_paper(pattern: &Pattern, size_mm: [f64; 2], paper: Paper) -> Result<Self, PatternError> {
        let Parts { pattern_mm, artwork, facts, cell_mm } = Parts::of(pattern, size_mm)?;
        Ok(Self { page: Page::on_paper(paper, pattern_mm, artwork, &facts)?, cell_mm })
    }

    /// Width and height of the pattern, mm.
    #[must_use]
    pub fn pattern_mm(&self) -> [f64; 2] {
        self.page.pattern_mm
    }

    /// Width and height of the page, mm.
    #[must_use]
    pub fn page_mm(&self) -> [f64; 2] {
        self.page.size_mm
    }

    /// The pattern's upper left corner on the page, mm from the page's own.
    #[must_use]
    pub fn origin_mm(&self) -> [f64; 2] {
        self.page.origin_mm
    }

    /// The text of the caption.
    #[must_use]
    pub fn caption(&self) -> &str {
        &self.page.caption
    }

    /// The page as PDF. Print dialogues are asked not to scale it.
    ///
    /// Colour cells are one image, with several samples per cell and without interpolation. Rectangles would be the
    /// obvious choice, but a PDF paints every device pixel that a shape touches, so each cell would grow by up to a
    /// pixel over its neighbours, and screens show seams. With an image, every device pixel belongs to one sample. With
    /// several samples per cell, a driver that smooths images nevertheless changes only the outermost hundredths of a
    /// mm.
    #[must_use]
    pub fn pdf(&self) -> Vec<u8> {
        pdf::write(&self.page)
    }

    /// The page as SVG, in mm. Colour cells are squares with crisp edges.
    #[must_use]
    pub fn svg(&self) -> String {
        svg::write(&self.page)
    }

    /// The page as PNG with this many px per m, which the file states. If cells are not whole px, a px is the mean of
    /// what it covers.
    ///
    /// # Errors
    ///
    /// [`PatternError::TooManyPixels`] for a picture that is too large for most programs.
    pub fn png(&self, px_per_m: u32) -> Result<Vec<u8>, PatternError> {
        png::write(&self.page, px_per_m)
    }

    /// Whether every colour cell is a whole number of px wide. False for discs.
    #[must_use]
    pub fn is_even(&self, px_per_m: u32) -> bool {
        let Some(cell_mm) = self.cell_mm else { return true };
        let px = f64::from(px_per_m) * cell_mm * 1e-3;
        let cells = self.page.pattern_mm[0].max(self.page.pattern_mm[1]) / cell_mm;
        px > 0.5 && (px - px.round()).abs() * cells < 1e-3
    }

    /// The resolution nearest to this one at which [`Print::is_even`], px per m; none if no common resolution suits the
    /// cells.
    #[must_use]
    pub fn even_px_per_m(&self, px_per_m: u32) -> Option<u32> {
        let Some(cell_mm) = self.cell_mm else { return Some(px_per_m) };
        let px_per_cell = f64::from(px_per_m) * cell_mm * 1e-3;
        let most = (4.0 * px_per_cell).ceil().max(2.0) as u32;
        let resolutions = (1..=most).map(|px| (f64::from(px) / (cell_mm * 1e-3)).round());
        let even =
            resolutions.filter(|px| *px <= f64::from(u32::MAX)).map(|px| px as u32).filter(|&px| self.is_even(px));
        even.min_by_key(|px| px.abs_diff(px_per_m))
    }
}

/// The content of a page, before it is placed.
struct Parts {
    pattern_mm: [f64; 2],
    artwork: Artwork,
    facts: Vec<String>,
    cell_mm: Option<f64>,
}

impl Parts {
    fn of(pattern: &Pattern, size_mm: [f64; 2]) -> Result<Self, PatternError> {
        pattern.check_size(size_mm)?;
        let [dark, bright] = pattern.levels;
        let (mut pattern_mm, mut cell) = (size_mm, None);
        let mut facts = vec![format!("fingervision {}", env!("CARGO_PKG_VERSION"))];
        let artwork = match pattern.motif {
            Motif::Colour { cell_mm } => {
                let cells = pattern.colours(size_mm)?.into_cells();
                let (columns, rows) = cells.size();
                (pattern_mm, cell) = ([columns, rows].map(|count| count as f64 * cell_mm), Some(cell_mm));
                facts.extend(["colour".into(), format!("cell {} mm", length(cell_mm))]);
                facts.push(format!("{columns} x {rows} cells"));
                Artwork::Cells(Image::from_fn(columns, rows, |x, y| cells.at(x, y).map(|level| level as u8)))
            }
            Motif::Dots { count: [columns, rows], diameter_mm } => {
                facts.extend([format!("{columns} x {rows} dots"), format!("diameter {} mm", length(diameter_mm))]);
                let discs = discs::dots([columns, rows], diameter_mm, size_mm);
                Artwork::Discs { discs, dark, bright }
            }
            Motif::Speckle { diameter_mm, coverage } => {
                facts.extend(["speckle".into(), format!("diameter {} mm", length(diameter_mm))]);
                facts.push(format!("coverage {} %", length(100.0 * coverage)));
                let (discs, _) = discs::speckle(diameter_mm, coverage, size_mm, pattern.seed)?;
                let discs = discs.into_iter().flat_map(|disc| disc.copies(size_mm)).collect();
                Artwork::Discs { discs, dark, bright }
            }
        };
        facts.push(format!("{} x {} mm", length(pattern_mm[0]), length(pattern_mm[1])));
        facts.push(format!("levels {dark}-{bright}"));
        if !matches!(pattern.motif, Motif::Dots { .. }) {
            facts.push(format!("seed {}", pattern.seed));
        }
        facts.push("print at 100 %".into());
        Ok(Self { pattern_mm, artwork, facts, cell_mm: cell })
    }
}

/// A length in mm to a tenth of a micrometre, without trailing zeros.
fn length(mm: f64) -> String {
    let text = format!("{mm:.4}");
    text.trim_end_matches('0').trim_end_matches('.').into()
}

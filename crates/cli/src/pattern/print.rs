//! Writing the page.

use std::fmt;
use std::path::{Path, PathBuf};

use fingervision_gel::{Paper, Print};
use fingervision_sink::write_file;
use serde::Serialize;

use super::Args;
use crate::failure::Failure;
use crate::output::refuse_existing;

/// Default width and height of a pattern, mm.
const SIZE_MM: [f64; 2] = [30.0, 30.0];
/// Black and white on paper.
const LEVELS: [u8; 2] = [0, 255];
/// Resolution of most printers, px per inch.
const USUAL_DPI: f64 = 1200.0;
const M_PER_INCH: f64 = 0.0254;

/// The result.
#[derive(Debug, Serialize)]
pub(super) struct Written {
    file: PathBuf,
    pattern_mm: [f64; 2],
    page_mm: [f64; 2],
    caption: String,
    /// Only for a PNG.
    #[serde(skip_serializing_if = "Option::is_none")]
    px_per_m: Option<u32>,
}

/// The values of `--page`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum PageName {
    /// 210x297 mm
    A4,
    /// 8.5x11 inches
    Letter,
}

impl From<PageName> for Paper {
    fn from(name: PageName) -> Self {
        match name {
            PageName::A4 => Self::A4,
            PageName::Letter => Self::Letter,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Pdf,
    Svg,
    Png,
}

pub(super) fn write(args: &Args, file: &Path) -> Result<Written, Failure> {
    let format = format(file)?;
    if !args.overwrite {
        refuse_existing(file)?;
    }
    if args.dpi.is_some() && format != Format::Png {
        return Err(Failure::new(
            format!("--dpi is only for PNG: {} has no px", file.display()),
            "leave --dpi out, or name the file .png",
        ));
    }
    let size_mm = args.pattern.size_mm.unwrap_or(SIZE_MM);
    let pattern = args.pattern.pattern(size_mm, LEVELS)?;
    let print = match args.page {
        Some(page) => Print::on_paper(&pattern, size_mm, page.into())?,
        None => Print::new(&pattern, size_mm)?,
    };
    let [width, height] = print.pattern_mm();
    if (0..2).any(|axis| (print.pattern_mm()[axis] - size_mm[axis]).abs() > 1e-6) {
        let [asked_width, asked_height] = size_mm;
        args.output.note(&format!(
            "the pattern is {width:.4}x{height:.4} mm: {asked_width}x{asked_height} mm is not a whole number of cells"
        ));
    }
    let px_per_m = (format == Format::Png).then(|| resolution(args, &print));
    let bytes = match (format, px_per_m) {
        (Format::Png, Some(px_per_m)) => print.png(px_per_m)?,
        (Format::Svg, _) => print.svg().into_bytes(),
        _ => print.pdf(),
    };
    write_file(file, &bytes)?;
    let caption = print.caption().to_string();
    Ok(Written { file: file.to_owned(), pattern_mm: [width, height], page_mm: print.page_mm(), caption, px_per_m })
}

fn format(file: &Path) -> Result<Format, Failure> {
    let ending = file.extension().and_then(|ending| ending.to_str()).unwrap_or_default().to_ascii_lowercase();
    match ending.as_str() {
        "pdf" => Ok(Format::Pdf),
        "svg" => Ok(Format::Svg),
        "png" => Ok(Format::Png),
        _ => Err(Failure::new(
            format!("{}: a pattern cannot be written in this format", file.display()),
            "end the name in .pdf, .svg or .png",
        )),
    }
}

/// Px per m: as requested, with a note if pixels then cover parts of several cells; otherwise the best value for the
/// cells.
fn resolution(args: &Args, print: &Print) -> u32 {
    let px_per_m = |dpi: f64| (dpi / M_PER_INCH).round() as u32;
    let wanted = px_per_m(args.dpi.unwrap_or(USUAL_DPI));
    let even = print.even_px_per_m(wanted);
    let chosen = if args.dpi.is_some() { wanted } else { even.unwrap_or(wanted) };
    if !print.is_even(chosen) {
        let better = even.map_or_else(String::new, |even| {
            format!("; --dpi {} makes every cell a whole number of px", decimal(f64::from(even) * M_PER_INCH))
        });
        args.output
            .note(&format!("a cell is not a whole number of px: pixels on its edges have a mixed colour{better}"));
    }
    chosen
}

/// A number to four decimals, without trailing zeros.
fn decimal(value: f64) -> String {
    format!("{value:.4}").trim_end_matches('0').trim_end_matches('.').to_string()
}

impl fmt::Display for Written {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([width, height], [page_width, page_height]) = (self.page_mm_of_pattern(), self.page_mm.map(decimal));
        writeln!(f, "{}: {width} x {height} mm on a page of {page_width} x {page_height} mm", self.file.display())?;
        if let Some(px_per_m) = self.px_per_m {
            writeln!(f, "resolution {} dpi, stored as {px_per_m} px per m", decimal(f64::from(px_per_m) * M_PER_INCH))?;
        }
        write!(f, "{}", self.caption)
    }
}

impl Written {
    fn page_mm_of_pattern(&self) -> [String; 2] {
        self.pattern_mm.map(decimal)
    }
}

//! A report as text: the deepest frame, and the mean over frames.

use std::fmt;

use super::report::{
    Components, Errors, FieldErrors, ForceReport, FrameReport, LoadErrors, PixelCounts, Region, Regions, Report,
};

/// Width of the names of rows.
const NAME: usize = 26;
/// Shown for a missing figure.
const NONE: &str = "—";

/// The name of a region.
pub(super) fn region_name(region: Region, border_mm: f64) -> String {
    match region {
        Region::Everywhere => "everywhere".into(),
        Region::Inside => "inside contact".into(),
        Region::Border => format!("within {border_mm} mm of border"),
        Region::Outside => "outside".into(),
    }
}

/// A part of a whole, in percent.
pub(super) fn percent(part: u64, whole: u64) -> String {
    if whole == 0 { NONE.into() } else { format!("{:.1} %", 100.0 * part as f64 / whole as f64) }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, width, height] = self.region;
        writeln!(f, "run       {}: {}", self.run.display(), self.fields.join(", "))?;
        writeln!(f, "truth     {}", self.truth.display())?;
        writeln!(f, "compared  {} frames of {width}x{height} px at ({x}, {y})", self.frames)?;
        if let Some(FrameReport { true_depth_mm, true_flow_px, .. }) = self.deepest() {
            let depth = true_depth_mm.map(|depth| format!(": {} mm deep", figure(Some(depth), 3)));
            let flow = true_flow_px.map(|flow| format!(", moved by up to {} px", figure(Some(flow), 2)));
            let (depth, flow) = (depth.unwrap_or_default(), flow.unwrap_or_default());
            writeln!(f, "deepest   frame {}{depth}{flow}", self.deepest_frame)?;
        }
        for note in &self.notes {
            writeln!(f, "note      {note}")?;
        }
        let Some(deepest) = self.deepest() else { return Ok(()) };
        let shown = [(self.deepest_title(), &deepest.errors), (self.mean_title(), &self.mean)];
        self.write_pixels(f, "Pixels", &shown, |errors| Some(&errors.pixels))?;
        self.write_regions(f, "Flow error, px", &shown, |errors| errors.flow_px.as_ref())?;
        self.write_pixels(f, "Pixels of depth", &shown, |errors| errors.depth_pixels.as_ref())?;
        self.write_regions(f, "Depth error, mm", &shown, |errors| errors.depth_mm.as_ref())?;
        if let Some(Errors { correlation, .. }) = self.pooled.depth_mm.and_then(|depth| depth.everywhere) {
            let all = figure(correlation, 4);
            let peaks = figure(self.peak_depth_correlation, 4);
            writeln!(f, "  correlation over all frames {all}, of the peaks over the frames {peaks}")?;
        }
        let heading = "Depth where flow valid, mm";
        self.write_regions(f, heading, &shown, |errors| errors.depth_where_valid_mm.as_ref())?;
        write_components(f, &shown)?;
        write_overlap(f, &shown)?;
        self.write_force(f)?;
        if self.pooled.flow_px.is_some() || self.pooled.depth_mm.is_some() {
            writeln!(f)?;
            writeln!(
                f,
                "bias: mean of estimate − truth; peak: largest estimate − largest truth; for the flow, of its length."
            )?;
            writeln!(f, "The border region lies on both sides of the border: its inner half is also inside contact.")?;
        }
        Ok(())
    }
}

type Shown<'a> = [(String, &'a FieldErrors); 2];

impl Report {
    fn deepest_title(&self) -> String {
        format!("frame {}, the deepest", self.deepest_frame)
    }

    fn mean_title(&self) -> String {
        format!("mean of {} frames", self.frames)
    }

    fn write_pixels(
        &self,
        f: &mut fmt::Formatter<'_>,
        heading: &str,
        shown: &Shown,
        counts: impl Fn(&FieldErrors) -> Option<&Regions<PixelCounts>>,
    ) -> fmt::Result {
        if shown.iter().all(|(_, errors)| counts(errors).is_none()) {
            return Ok(());
        }
        write_heading(f, heading, &["compared", "hidden", "not valid"])?;
        for (title, errors) in shown {
            writeln!(f, "  {title}")?;
            for region in Region::ALL {
                let pixels = counts(errors).and_then(|counts| counts.get(region)).copied().unwrap_or_default();
                let parts = [pixels.compared, pixels.hidden, pixels.not_valid].map(|part| percent(part, pixels.all()));
                write_row(f, 4, &region_name(region, self.border_mm), &parts)?;
            }
        }
        Ok(())
    }

    fn write_regions(
        &self,
        f: &mut fmt::Formatter<'_>,
        heading: &str,
        shown: &Shown,
        regions: impl Fn(&FieldErrors) -> Option<&Regions>,
    ) -> fmt::Result {
        if shown.iter().all(|(_, errors)| regions(errors).is_none()) {
            return Ok(());
        }
        write_heading(f, heading, &FIGURES)?;
        for (title, errors) in shown {
            writeln!(f, "  {title}")?;
            for region in Region::ALL {
                let errors = regions(errors).and_then(|regions| regions.get(region));
                write_row(f, 4, &region_name(region, self.border_mm), &figures(errors))?;
            }
        }
        Ok(())
    }

    fn write_force(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(ForceReport { true_peak_n, mean_n, largest_n, mean_of_peak, normal, shear, torque }) = &self.force
        else {
            return Ok(());
        };
        write_heading(f, "Force error, N", &["x", "y", "z"])?;
        if let Some(force) = self.deepest().and_then(|deepest| deepest.force) {
            writeln!(f, "  {}", self.deepest_title())?;
            write_row(f, 4, "true", &force.true_n.map(|value| figure(value, 3)))?;
            write_row(f, 4, "estimated", &force.estimated_n.map(|value| figure(value, 3)))?;
            write_row(f, 4, "error", &force.error_n.map(|value| figure(value, 3)))?;
        }
        writeln!(f, "  {} frames", self.frames)?;
        write_row(f, 4, "mean", &mean_n.map(|value| figure(value, 3)))?;
        write_row(f, 4, "largest", &largest_n.map(|value| figure(value, 3)))?;
        let of_peak = mean_of_peak.map(|part| part.map_or(NONE.into(), |part| format!("{:.1} %", 100.0 * part)));
        write_row(f, 4, &format!("mean, of {true_peak_n:.2} N"), &of_peak)?;
        write_heading(f, "Force and torque", &["true peak", "mean error", "of peak", "at peak"])?;
        let parts = [("normal force, N", normal), ("shear force, N", shear), ("torque, N mm", torque)];
        parts.iter().try_for_each(|(name, errors)| errors.as_ref().map_or(Ok(()), |errors| write_load(f, name, errors)))
    }
}

/// The errors of a part of the load, in its unit and in percent of its peak.
fn write_load(f: &mut fmt::Formatter<'_>, name: &str, errors: &LoadErrors) -> fmt::Result {
    let of_peak = |part: Option<f64>| part.map_or(NONE.into(), |part| format!("{:.1} %", 100.0 * part));
    let LoadErrors { true_peak, mean, mean_of_peak, at_peak, .. } = errors;
    let cells = [figure(Some(*true_peak), 3), figure(Some(*mean), 3), of_peak(*mean_of_peak), of_peak(*at_peak)];
    write_row(f, 2, name, &cells)
}

const FIGURES: [&str; 7] = ["mean", "rms", "95 %", "largest", "bias", "peak", "correlation"];

fn figures(errors: Option<&Errors>) -> [String; 7] {
    let of = |value: fn(&Errors) -> f64| figure(errors.map(value), 4);
    [
        of(|errors| errors.mean),
        of(|errors| errors.root_mean_square),
        of(|errors| errors.percentile_95),
        of(|errors| errors.largest),
        of(|errors| errors.bias),
        of(Errors::peak_error),
        figure(errors.and_then(|errors| errors.correlation), 4),
    ]
}

/// A number with this many decimals, without negative zero.
fn figure(value: Option<f64>, decimals: usize) -> String {
    let Some(value) = value else { return NONE.into() };
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(zero) if zero.chars().all(|c| "0.".contains(c)) => zero.into(),
        Some(size) => format!("−{size}"),
        None => text,
    }
}

fn write_components(f: &mut fmt::Formatter<'_>, shown: &Shown) -> fmt::Result {
    if shown.iter().all(|(_, errors)| errors.displacement_mm.is_none()) {
        return Ok(());
    }
    write_heading(f, "Displacement error, mm", &FIGURES)?;
    for (title, errors) in shown {
        writeln!(f, "  {title}")?;
        if let Some(Components { x, y, z }) = &errors.displacement_mm {
            for (name, errors) in [("x", x), ("y", y), ("z", z)] {
                write_row(f, 4, name, &figures(errors.as_ref()))?;
            }
        }
    }
    Ok(())
}

fn write_overlap(f: &mut fmt::Formatter<'_>, shown: &Shown) -> fmt::Result {
    if shown.iter().all(|(_, errors)| errors.contact_overlap.is_none()) {
        return Ok(());
    }
    write_heading(f, "Contact", &["overlap"])?;
    shown.iter().try_for_each(|(title, errors)| write_row(f, 2, title, &[figure(errors.contact_overlap, 4)]))
}

fn write_heading(f: &mut fmt::Formatter<'_>, heading: &str, columns: &[&str]) -> fmt::Result {
    writeln!(f)?;
    write_row(f, 0, heading, columns)
}

/// A name and its cells, each cell as wide as the widest name of a column needs.
fn write_row(f: &mut fmt::Formatter<'_>, indent: usize, name: &str, cells: &[impl AsRef<str>]) -> fmt::Result {
    write!(f, "{:indent$}{name:width$}", "", width = NAME - indent)?;
    for cell in cells {
        let width = if cells.len() == FIGURES.len() { 9 } else { 10 };
        write!(f, "  {:>width$}", cell.as_ref())?;
    }
    writeln!(f)
}

//! The report of a depth fit as text.

use std::fmt;

use fingervision_touch::{DepthLaw, DepthLine, PerspectiveGain};

use super::DepthFit;
use super::regression::LineFit;

impl fmt::Display for DepthFit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.presses.iter().map(|press| press.curve.name.chars().count()).max().unwrap_or(0).max(12);
        writeln!(f, "{:width$}  frames       r          slope, mm      intercept, mm  residual, mm", "press")?;
        for press in &self.presses {
            write_row(f, &press.curve.name, width, &press.line)?;
        }
        if self.presses.len() > 1 {
            write_row(f, "all together", width, &self.pooled)?;
        }
        writeln!(f)?;
        writeln!(f, "law          error, mm  on a press left out, mm  depth.density")?;
        for law in &self.laws {
            let left_out = law.left_out_error_mm.map_or_else(|| "–".into(), |error| format!("{error:.3}"));
            let best = if law.method == self.best && self.laws.len() > 1 { "  least error" } else { "" };
            let name = law.method.name();
            writeln!(f, "{name:11}  {:9.3}  {left_out:>23}  {}{best}", law.error_mm, toml_of(&law.law))?;
        }
        for press in self.presses.iter().filter(|press| press.curve.lost > 0) {
            let frames = press.curve.lost + press.curve.points.len();
            writeln!(f, "note         {}: {} of {frames} frames were lost", press.curve.name, press.curve.lost)?;
        }
        for warning in &self.warnings {
            writeln!(f, "warning      {warning}")?;
        }
        Ok(())
    }
}

fn write_row(f: &mut fmt::Formatter<'_>, name: &str, width: usize, line: &LineFit) -> fmt::Result {
    let with = |value: f64, uncertainty: f64| format!("{value:.3} ± {uncertainty:.3}");
    let (slope, intercept) =
        (with(line.slope, line.slope_uncertainty), with(line.intercept, line.intercept_uncertainty));
    let LineFit { count, correlation, residual, .. } = line;
    writeln!(f, "{name:width$}  {count:6}  {correlation:6.4}  {slope:>17}  {intercept:>17}  {residual:12.3}")
}

/// The law as written to a profile.
fn toml_of(law: &DepthLaw) -> String {
    match law {
        DepthLaw::Line(DepthLine { slope_mm, intercept_mm }) => {
            format!("{{ slope_mm = {slope_mm:.3}, intercept_mm = {intercept_mm:.3} }}")
        }
        DepthLaw::Perspective(PerspectiveGain { gain }) => format!("{{ gain = {gain:.4} }}"),
    }
}

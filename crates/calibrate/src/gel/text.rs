//! The report of a gel fit as text.

use std::fmt;

use super::{FrameReport, GelEstimate, GelReport};

impl fmt::Display for GelReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.presses.iter().map(|press| press.name.chars().count()).max().unwrap_or(0).max(12);
        writeln!(
            f,
            "{:width$}  depth, mm  from images  contact radius, mm  residual before  after, %  force, N  predicted",
            "press"
        )?;
        for press in &self.presses {
            for frame in &press.frames {
                write_frame(f, &press.name, width, frame)?;
            }
        }
        writeln!(f, "\nvalue               profile       fitted  deviation   from scatter")?;
        for estimate in &self.estimates {
            write_estimate(f, estimate)?;
        }
        if let Some(correlation) = self.correlation {
            writeln!(f, "correlation         {correlation:+.2} between Poisson's ratio and thickness")?;
        }
        let (before, after) = (100.0 * self.unexplained_before, 100.0 * self.unexplained);
        writeln!(
            f,
            "residual            {before:.2} % of the depth with the profile's gel, {after:.2} % with the fitted gel"
        )?;
        for warning in &self.warnings {
            writeln!(f, "warning             {warning}")?;
        }
        Ok(())
    }
}

fn write_frame(f: &mut fmt::Formatter<'_>, name: &str, width: usize, frame: &FrameReport) -> fmt::Result {
    let FrameReport { depth_mm, found_mm, contact_radius_mm, unexplained_before, unexplained, .. } = frame;
    let number =
        |value: Option<f64>, digits: usize| value.map_or_else(|| "–".into(), |value| format!("{value:.digits$}"));
    let before = number(unexplained_before.map(|part| 100.0 * part), 2);
    let after = 100.0 * unexplained;
    let (force, predicted) = (number(frame.force_n, 3), number(frame.predicted_force_n, 3));
    writeln!(
        f,
        "{name:width$}  {depth_mm:>9.3}  {found_mm:>11.3}  {contact_radius_mm:>18.2}  {before:>15}  {after:>8.2}  {force:>8}  {predicted:>9}"
    )
}

fn write_estimate(f: &mut fmt::Formatter<'_>, estimate: &GelEstimate) -> fmt::Result {
    let number = |value: Option<f64>| value.map_or_else(|| "–".into(), |value| format!("{value:.4}"));
    let GelEstimate { key, before, value, deviation, scatter, remark, .. } = estimate;
    let [before, value, deviation, scatter] = [before, value, deviation, scatter].map(|value| number(*value));
    writeln!(f, "{key:18} {before:>8} {value:>12} {deviation:>10} {scatter:>14}  {remark}")
}

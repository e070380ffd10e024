//! The report of a camera fit as text.

use std::fmt;

use super::corners::{CornerFit, LENS_PLACES, POSE_PLACES};
use super::observability::{BlindDirection, Estimate};
use super::report::CameraReport;
use super::residuals::Residuals;
use super::thresholds::THRESHOLDS;
use super::unknowns::{Unknown, unknowns_of};

impl fmt::Display for CameraReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for slide in &self.slides {
            let ((width, height), [x, y]) = (slide.size, slide.usual_px);
            writeln!(
                f,
                "slide     {} images of {width}x{height} px, {} mm a step along {:.0}°: {:.2} px a step, {} nodes tracked",
                slide.images,
                slide.step_mm,
                slide.direction_deg,
                x.hypot(y),
                slide.nodes
            )?;
        }
        self.write_table(f)?;
        self.write_estimates(f)?;
        self.write_blind(f)
    }
}

impl CameraReport {
    fn write_table(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "\nresidual                     nodes    mean px   st. dev. px    mean mm on the board")?;
        let table = &self.residuals;
        for (name, Residuals { nodes, mean_px, deviation_px, .. }) in [
            ("before, plain camera", table.before),
            ("after", table.after),
            ("test, before", table.test_before),
            ("test, after", table.test),
        ] {
            let mean_mm = mean_px / self.px_per_mm;
            writeln!(f, "{name:<24} {nodes:>9} {mean_px:>10.5} {deviation_px:>13.5} {mean_mm:>12.6}")?;
        }
        let (ratio, test) = (self.after_over_before, self.test_over_after);
        writeln!(f, "after / before {ratio:.4}, test / after {test:.3}")?;
        writeln!(
            f,
            "Du et al. 2021 print 4.57e-3 before, 2.23e-3 after, 2.16e-3 in the test (st. dev. 4.37e-3, 1.34e-3, 1.27e-3) and\n\
             name no unit: compare ratios, 0.49 and 0.97. Before is the plain camera, upright and without distortion, its\n\
             scale taken from the mean flow: the published start, with the size of a pixel taken from the data."
        )
    }

    fn write_estimates(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "\nunknown                  value   uncertainty   prior")?;
        for Estimate { name, value, uncertainty, determined } in &self.knowledge.estimates {
            let prior = self.priors.iter().find(|(known, _)| known == name);
            let prior = prior.map_or_else(
                || "none".into(),
                |(_, prior)| format!("{} ± {}", short(prior.value), short(prior.deviation)),
            );
            let Some(uncertainty) = uncertainty else {
                let source = if self.origin_is_middle {
                    "set: the origin is the point that the middle of the picture shows"
                } else {
                    "as given"
                };
                writeln!(f, "{name:<18} {value:>11.5}             -   {source}")?;
                continue;
            };
            let is_prior = determined.is_some_and(|determined| determined < THRESHOLDS.determined);
            let remark = if is_prior { ", which determines it: the slides contain little information" } else { "" };
            writeln!(f, "{name:<18} {value:>11.5} {uncertainty:>13.5}   {prior}{remark}")?;
        }
        Ok(())
    }

    fn write_blind(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "\nnot determined  the position of the origin on the board: every point of the board slides in the same way"
        )?;
        for BlindDirection { open, change, meaning, remedy } in &self.knowledge.blind {
            writeln!(f, "not determined  {meaning}")?;
            let change: Vec<String> = change.iter().map(|(name, by)| format!("{name} {}", signed(*by))).collect();
            let open = open.map_or_else(
                || "not determined at all".into(),
                |open| format!("determined only to {open:.1} times this"),
            );
            writeln!(f, "          together {} do not change the flow; this is {open}", change.join(", "))?;
            writeln!(f, "          what helps: {remedy}")?;
        }
        writeln!(f, "not determined  the step itself: if it is wrong by 1 %, focal length / distance is wrong by 1 %")
    }
}

impl fmt::Display for CornerFit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Residuals { nodes, mean_px, deviation_px, largest_px } = self.reprojection;
        writeln!(f, "corners   {nodes} in {} images", self.images)?;
        writeln!(f, "error     {mean_px:.4} px on average, st. dev. {deviation_px:.4} px, {largest_px:.3} px at most")?;
        writeln!(f, "\nunknown                  value   uncertainty")?;
        let values = unknowns_of(&self.params);
        for (place, uncertainty) in LENS_PLACES.into_iter().chain(POSE_PLACES).zip(&self.uncertainty) {
            writeln!(f, "{:<18} {:>11.5} {uncertainty:>13.5}", Unknown::ALL[place].name(), values[place])?;
        }
        writeln!(
            f,
            "\nThe pose is that of the first image: gel space and its origin are those of the board in that image."
        )
    }
}

/// Four significant digits.
fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let decimals = (3 - value.abs().log10().floor() as i32).max(0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

fn signed(value: f64) -> String {
    if value < 0.0 { format!("−{}", short(-value)) } else { format!("+{}", short(value)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits_and_no_needless_zeros() {
        assert_eq!(
            [short(25.0), short(0.5), short(0.001_234_56), short(0.0), short(12_345.6)],
            ["25", "0.5", "0.001235", "0", "12346"]
        );
        assert_eq!([signed(-1.75), signed(28.0)], ["−1.75", "+28"]);
    }
}

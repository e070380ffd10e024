//! The curves of all presses as small multiples, as in figure 5 of [Du2021]: feature against depth, one panel for each
//! place.
//!
//! [Du2021]: https://doi.org/10.1109/LRA.2021.3061306

use fingervision_image::Image;
use fingervision_plot::{Curve, CurvePanel, CurvePlots, StraightLine};

use super::{DepthFit, Place};

impl DepthFit {
    /// Draws the density feature against the known depth: a panel for the presses at each place, with the pooled lines.
    #[must_use]
    pub fn draw(&self) -> Image<[u8; 3]> {
        let panels = [Place::Centre, Place::Midway, Place::Corner].into_iter().filter_map(|place| {
            let curves: Vec<Curve> =
                self.presses.iter().filter(|press| press.curve.place == place).map(curve).collect();
            (!curves.is_empty()).then(|| CurvePanel { heading: place.heading().into(), curves })
        });
        let line = |name: &str, slope: f64, intercept: f64| StraightLine {
            name: name.into(),
            slope: 1.0 / slope,
            intercept: -intercept / slope,
        };
        CurvePlots {
            title: "Density feature against depth".into(),
            facts: self.facts(),
            x_name: "Depth, mm".into(),
            y_name: "Largest density feature, dimensionless".into(),
            panels: panels.collect(),
            lines: vec![
                line("line", self.pooled.slope, self.pooled.intercept),
                line("line through the origin", self.origin.slope, 0.0),
            ],
        }
        .draw()
    }

    /// The line below the title.
    pub(super) fn facts(&self) -> String {
        let together = self.pooled.correlation;
        if self.presses.len() == 1 {
            return format!("1 press, r {together:.3}");
        }
        format!(
            "{} presses, r {together:.3} together, {:.3} or more each; slopes differ by a factor of {:.1}",
            self.presses.len(),
            self.presses.iter().map(|press| press.line.correlation).fold(1.0, f64::min),
            self.slope_factor
        )
    }
}

fn curve(press: &super::PressFit) -> Curve {
    let points = press.curve.points.iter().map(|point| [point.depth_mm, point.feature]).collect();
    Curve { name: format!("{}, r {:.3}", press.curve.name, press.line.correlation), points }
}

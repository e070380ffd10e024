//! The residual over Poisson's ratio and thickness, and measured against predicted forces.

use fingervision_image::Image;
use fingervision_plot::{Curve, CurvePanel, CurvePlots, HeatPanel, HeatPanels, HeatScale, StraightLine};

use super::{GelReport, ResidualGrid};

/// Side of the residual's map, px.
const SIDE: usize = 360;
/// Half the length of the cross at the fitted gel, px.
const CROSS: usize = 8;
/// Bands of one colour in the map: their borders are its contours.
const BANDS: f32 = 14.0;
/// The map ends at this multiple of the least residual.
const MOST: f32 = 4.0;

impl GelReport {
    /// Draws the residual over Poisson's ratio and thickness, in bands, with a cross at the fitted gel.
    #[must_use]
    pub fn draw(&self) -> Image<[u8; 3]> {
        let [ratio, thickness, _] = &self.estimates;
        let (ratios, thicknesses) = (&self.residual.poissons_ratios, &self.residual.thicknesses_mm);
        let at = [ratio.value.unwrap_or(f64::NAN), thickness.value.unwrap_or(f64::NAN)];
        let values = self.residual.drawn(at);
        let ends = |values: &[f64]| (values.first().copied().unwrap_or(0.0), values.last().copied().unwrap_or(0.0));
        let ((low, high), (thin, thick)) = (ends(ratios), ends(thicknesses));
        let least = self.residual.unexplained.iter().copied().fold(f64::INFINITY, f64::min);
        let facts = format!(
            "Residual of the motion around contact, root mean square divided by the depth  ·  {:.2} % with the profile's \
             gel, {:.2} % with the fitted gel",
            100.0 * self.unexplained_before,
            100.0 * self.unexplained
        );
        let panel = HeatPanel {
            heading: "Over Poisson's ratio and thickness, %".into(),
            values: &values,
            scale: HeatScale { high: 100.0 * least as f32 * MOST, ..HeatScale::from_zero(1.0) },
            note: format!("Right: {low:.3} to {high:.3}. Down: {thin:.2} to {thick:.2} mm. Cross: the fit."),
        };
        let [before, after] = self.maps.each_ref().map(in_percent);
        let shown = |values, heading: &str, limit: f32, note: &str| HeatPanel {
            heading: format!("{heading}, %"),
            values,
            scale: HeatScale::from_zero(limit.max(1e-3)),
            note: note.into(),
        };
        let panels = vec![
            panel,
            shown(&before, "Deepest frame, profile's gel", largest(&before), "On the gel, without contact and sides."),
            shown(&after, "Deepest frame, fitted gel", largest(&after), "The same on its own scale."),
        ];
        let title =
            format!("Gel from {} presses: Poisson's ratio {:.3}, {:.2} mm thick", self.presses.len(), at[0], at[1]);
        let title = if self.presses.len() == 1 { title.replacen("1 presses", "a press", 1) } else { title };
        HeatPanels { title: &title, facts: &facts, size: (SIDE, SIDE), rows: vec![panels] }.draw()
    }

    /// Draws measured against predicted normal forces, one curve for each press; none without forces.
    #[must_use]
    pub fn draw_forces(&self) -> Option<Image<[u8; 3]>> {
        let curve = |press: &super::GelPressReport| {
            let points = press.frames.iter().filter_map(|frame| Some([frame.predicted_force_n?, frame.force_n?]));
            let points: Vec<_> = points.collect();
            (!points.is_empty()).then(|| Curve { name: press.name.clone(), points })
        };
        let curves: Vec<_> = self.presses.iter().filter_map(curve).collect();
        let modulus = &self.estimates[2];
        let deviation = modulus.deviation.map_or_else(String::new, |deviation| format!(" ± {deviation:.3}"));
        let facts = format!("Young's modulus {:.3}{deviation} MPa", modulus.value?);
        (!curves.is_empty()).then(|| {
            CurvePlots {
                title: "Normal force, measured against predicted".into(),
                facts,
                x_name: "Predicted by the fitted gel, N".into(),
                y_name: "Measured, N".into(),
                panels: vec![CurvePanel { heading: "All presses".into(), curves }],
                lines: vec![StraightLine { name: "equal".into(), slope: 1.0, intercept: 0.0 }],
            }
            .draw()
        })
    }
}

fn in_percent(map: &Image<f32>) -> Image<f32> {
    Image::from_fn(map.width(), map.height(), |x, y| 100.0 * map.at(x, y))
}

fn largest(map: &Image<f32>) -> f32 {
    map.values().iter().copied().filter(|value| value.is_finite()).fold(0.0, f32::max)
}

impl ResidualGrid {
    /// The residual in %, in bands, thickness downwards; a cross at a gel.
    fn drawn(&self, [ratio, thickness]: [f64; 2]) -> Image<f32> {
        let (columns, rows) = (self.poissons_ratios.len(), self.thicknesses_mm.len());
        let least = self.unexplained.iter().copied().fold(f64::INFINITY, f64::min) as f32;
        let band = MOST * least / BANDS;
        let split = |pixel: usize, count: usize| {
            let place = pixel as f64 / (SIDE - 1) as f64 * (count - 1) as f64;
            let whole = (place as usize).min(count - 2);
            (whole, place - whole as f64)
        };
        let mut values = Image::from_fn(SIDE, SIDE, |x, y| {
            let ((column, right), (row, down)) = (split(x, columns), split(y, rows));
            let along = |row: usize| {
                let from = &self.unexplained[row * columns + column..][..2];
                from[0] + right * (from[1] - from[0])
            };
            let value = along(row) + down * (along(row + 1) - along(row));
            100.0 * band * (value as f32 / band).round()
        });
        let part = |value: f64, ends: &[f64]| (value - ends[0]) / (ends[ends.len() - 1] - ends[0]) * (SIDE - 1) as f64;
        let logarithms: Vec<f64> = self.thicknesses_mm.iter().map(|thickness| thickness.ln()).collect();
        let centre = [part(ratio, &self.poissons_ratios), part(thickness.ln(), &logarithms)];
        if centre.iter().all(|at| (0.0..SIDE as f64).contains(at)) {
            let [x, y] = centre.map(|at| at.round() as usize);
            for step in 0..=2 * CROSS {
                for (x, y) in [((x + step).checked_sub(CROSS), Some(y)), (Some(x), (y + step).checked_sub(CROSS))] {
                    if let (Some(x), Some(y)) = (x.filter(|x| *x < SIDE), y.filter(|y| *y < SIDE)) {
                        values.row_mut(y)[x] = 100.0 * MOST * least;
                    }
                }
            }
        }
        values
    }
}

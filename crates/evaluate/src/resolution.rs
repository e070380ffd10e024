//! Spatial resolution of the flow: the smallest period of a displacement that it resolves, and its noise.
//!
//! The star of the DIC Challenge 2.0 \[Reu2022\]: a vertical displacement of 0.5 px that varies as a cosine along y,
//! with a period that grows along x from 10 to 300 px. For every period, the estimated flow is projected onto the true
//! cosine; the result is given relative to the true amplitude. Noise is the standard deviation of the flow between two
//! images at rest, which differ only by their noise. A method with coarser resolution has less noise, so the product of
//! both is compared.

use crate::matcher::Matcher;
use crate::pairs::BORDER_PX;
use crate::{Asked, EvaluateError, Table};
use fingervision_flow::{FlowField, FlowParams, Preset};
use fingervision_gel::{Light, Motion, Sheet, SheetRenderer};
use fingervision_image::{Image, Pixels};
use rayon::prelude::*;

/// Columns and rows of the images, px.
const SIZE: (usize, usize) = (2000, 500);

/// Amplitude of the star, px.
const AMPLITUDE_PX: f64 = 0.5;

/// Periods at the borders, px.
const PERIODS_PX: [f64; 2] = [10.0, 300.0];

/// Periods that are shown, px.
const SHOWN_PX: [f64; 10] = [16.0, 20.0, 26.0, 30.0, 40.0, 60.0, 77.0, 100.0, 150.0, 250.0];

/// Number of columns on both sides of a period's column that are averaged with it.
const SIDE: usize = 12;

/// A period is resolved if at least this part of the amplitude is found.
const RESOLVED: f64 = 0.9;

/// Side of a cell in the second pattern, px.
const FINE_CELL_PX: f64 = 2.0;

/// Measures the star on two patterns.
///
/// # Errors
///
/// [`EvaluateError::Flow`] if the default parameters do not fit the frames, which would be a bug.
pub fn measure() -> Result<Table, EvaluateError> {
    let grey = |preset| FlowParams { preset, colour: false, ..FlowParams::default() };
    let variants = [FlowParams::default(), grey(Preset::Affine), grey(Preset::Medium)];
    let sheets = [Sheet::default().cell_size_px, FINE_CELL_PX].map(|cell_size_px| Sheet {
        width: SIZE.0,
        height: SIZE.1,
        cell_size_px,
        ..Sheet::default()
    });
    let jobs: Vec<_> = sheets.iter().flat_map(|sheet| variants.iter().map(move |params| (sheet, params))).collect();
    let found = jobs.into_par_iter().map(|(sheet, params)| Found::by(params, sheet));
    let found = found.collect::<Result<Vec<_>, EvaluateError>>()?;
    let columns = ["colour", "grey", "search", "2 px: colour", "grey", "search"];
    let mut table =
        Table::new("Star of 0.5 px: part of the amplitude by period; cells of 4 px, then of 2 px", &columns);
    let mut row = |name: &str, asked: Option<Asked>, figure: &dyn Fn(&Found) -> f64| {
        table.push(name, asked, found.iter().map(figure).collect());
    };
    for period_px in SHOWN_PX {
        row(&format!("period {period_px} px"), None, &|found| found.amplitude(period_px));
    }
    row("smallest period with 90 % of the amplitude, px", Some(Asked::AtMost(30.0)), &Found::resolved_px);
    row("noise at rest, px", Some(Asked::AtMost(0.02)), &|found| found.noise_px);
    row("period times noise, px²", None, &|found| found.noise_px * found.resolved_px());
    Ok(table)
}

/// The result of one method on one pattern.
struct Found {
    flow: FlowField,
    noise_px: f64,
}

impl Found {
    fn by(params: &FlowParams, sheet: &Sheet) -> Result<Self, EvaluateError> {
        let renderer = SheetRenderer::new(sheet)?;
        let render = |motion: &Motion, seed: u64| renderer.render(motion, Light::EVEN, seed).map(Pixels::Rgb8);
        let mut matcher = Matcher::new(&render(&Motion::STILL, 1)?, params)?;
        let noise_px = deviation(&matcher.find(&render(&Motion::STILL, 2)?)?.flow.v);
        let flow = matcher.find(&render(&star(), 3)?)?.flow.clone();
        Ok(Self { flow, noise_px })
    }

    /// The amplitude found at the column of a period, over the true one.
    fn amplitude(&self, period_px: f64) -> f64 {
        let place = (period_px - PERIODS_PX[0]) / (PERIODS_PX[1] - PERIODS_PX[0]) * (SIZE.0 - 1) as f64;
        let column = place.round() as usize;
        let (mut product, mut square) = (0.0, 0.0);
        for x in column.saturating_sub(SIDE)..=(column + SIDE).min(SIZE.0 - 1) {
            for y in BORDER_PX..SIZE.1 - BORDER_PX {
                let (_, v) = star().displacement(x as f64, y as f64);
                product += v * f64::from(self.flow.v.at(x, y));
                square += v * v;
            }
        }
        product / square
    }

    /// The smallest period, px, such that this and all larger periods of whole px are resolved.
    fn resolved_px(&self) -> f64 {
        let [least, largest] = PERIODS_PX.map(|period| period as usize);
        let unresolved = (least + 2..largest - 2).rev().find(|&period| self.amplitude(period as f64) < RESOLVED);
        unresolved.map_or(PERIODS_PX[0], |period| (period + 1) as f64)
    }
}

fn star() -> Motion {
    Motion::Star {
        amplitude_px: AMPLITUDE_PX,
        crest_px: 0.5 * (SIZE.1 - 1) as f64,
        periods_px: PERIODS_PX,
        width_px: (SIZE.0 - 1) as f64,
    }
}

/// Standard deviation of a plane without its border.
fn deviation(plane: &Image<f32>) -> f64 {
    let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
    for y in BORDER_PX..SIZE.1 - BORDER_PX {
        for value in &plane.row(y)[BORDER_PX..SIZE.0 - BORDER_PX] {
            sum += f64::from(*value);
            squares += f64::from(*value).powi(2);
            count += 1.0;
        }
    }
    (squares / count - (sum / count).powi(2)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_amplitude_of_a_smoothed_star_is_the_smoothing_s() {
        // The mean over nine rows leaves sin(9 π/p) / (9 sin(π/p)) of a wave of period p.
        let mean = |x: usize, y: usize| {
            let rows = (0..9).map(|k| star().displacement(x as f64, y as f64 + f64::from(k) - 4.0).1);
            rows.sum::<f64>() / 9.0
        };
        let v = Image::from_fn(SIZE.0, SIZE.1, |x, y| mean(x, y) as f32);
        let found = Found { flow: FlowField { u: v.clone(), v }, noise_px: 0.0 };
        for period_px in [26.0, 40.0, 100.0] {
            let angle = std::f64::consts::PI / period_px;
            let expected = (9.0 * angle).sin() / (9.0 * angle.sin());
            let amplitude = found.amplitude(period_px);
            assert!((amplitude - expected).abs() < 0.01, "{period_px} px: {amplitude}, not {expected}");
        }
        // 90 % are left of a period of 35 px.
        assert!((found.resolved_px() - 36.0).abs() <= 1.5, "{}", found.resolved_px());
    }
}

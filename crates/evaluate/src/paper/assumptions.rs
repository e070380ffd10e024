//! The assumptions on which the pooled correlation of figure 5 depends, varied one by one.

use fingervision_calibrate::depth::{DepthFit, PressCurve};
use fingervision_gel::Scene;
use serde::Serialize;

use super::{Extent, Lab, Setting, published};
use crate::experiment::{ExperimentError, Following, Recording, calibrate};
use crate::page::{Cell, HtmlTable, Section};

/// One sensor and contact law, with the results for the pooled line.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Assumption {
    /// The contact law.
    pub law: &'static str,
    /// Distance of the camera from the gel, mm.
    pub distance_mm: f64,
    /// The smallest of the correlations of the nine single presses.
    pub least: f64,
    /// Pooled correlation of all nine.
    pub pooled: f64,
    /// The same with the value at rest of each press subtracted.
    pub zeroed: f64,
    /// The same with negative features set to 0.
    pub clamped: f64,
    /// Pooled correlation of the three presses at the centre.
    pub centre: f64,
    /// The steepest press's slope over the flattest one's.
    pub slope_factor: f64,
}

/// All combinations.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Assumptions {
    /// One entry per combination.
    pub rows: Vec<Assumption>,
}

const LAWS: [(&str, &str); 2] = [("sticking", "\"stick\""), ("frictionless", "\"frictionless\"")];
/// Distances of the camera, mm; the focal length is proportional to it, so that the gel keeps its size in the image.
const DISTANCES_MM: [f64; 4] = [7.5, 15.0, 25.0, 50.0];

pub(super) fn measure(lab: &Lab) -> Result<(Assumptions, Section), ExperimentError> {
    let distances: &[f64] = if lab.extent == Extent::Full { &DISTANCES_MM } else { &[15.0] };
    let mut rows = Vec::new();
    for (law, value) in LAWS {
        for &distance_mm in distances {
            let on_sensor = |scene: Scene| {
                let mut scene = Setting::Published.draft(scene, lab.extent)?;
                let focal = format!("[{0}, {0}]", 16.0 * distance_mm);
                let translation = format!("[0.0, 0.0, {distance_mm:.1}]");
                scene.set_all([
                    ("contact.law", value),
                    ("camera.focal_length_px", focal.as_str()),
                    ("camera.translation_mm", translation.as_str()),
                ])?;
                Recording::of(&scene, lab.cache)
            };
            let fit = calibrate(&on_sensor, Following::Dense)?;
            rows.push(assumption(law, distance_mm, &fit)?);
        }
    }
    let section = section(&rows);
    Ok((Assumptions { rows }, section))
}

fn assumption(law: &'static str, distance_mm: f64, fit: &DepthFit) -> Result<Assumption, ExperimentError> {
    let curves = || fit.presses.iter().map(|press| press.curve.clone());
    let zeroed = |mut curve: PressCurve| {
        let rest = curve.points.first().map_or(0.0, |point| point.feature);
        curve.points.iter_mut().for_each(|point| point.feature -= rest);
        curve
    };
    let clamped = |mut curve: PressCurve| {
        curve.points.iter_mut().for_each(|point| point.feature = point.feature.max(0.0));
        curve
    };
    let pooled = |curves: Vec<PressCurve>| Ok::<_, ExperimentError>(DepthFit::new(curves)?.pooled.correlation);
    Ok(Assumption {
        law,
        distance_mm,
        least: fit.presses.iter().map(|press| press.line.correlation).fold(1.0, f64::min),
        pooled: fit.pooled.correlation,
        zeroed: pooled(curves().map(zeroed).collect())?,
        clamped: pooled(curves().map(clamped).collect())?,
        centre: pooled(curves().take(3).collect())?,
        slope_factor: fit.slope_factor,
    })
}

fn section(rows: &[Assumption]) -> Section {
    let mut section = Section::new("assumptions", "What the pooled correlation depends on");
    section.text(
        "Nine presses at Poisson's ratio 0.35, with these assumptions varied: the contact law; the distance of the camera, with the same \
         size of the gel in the image; the zero level, by subtracting the value of each press at rest; negative features, by setting \
         them to 0. The last two columns are the correlation of the three presses at the centre alone, and the largest slope of a press \
         divided by the smallest one.",
    );
    let mut table = HtmlTable::new(
        "Correlation of the largest feature with depth",
        [
            "contact",
            "distance, mm",
            "least of nine",
            "all nine",
            "zero level subtracted",
            "negative set to 0",
            "centre alone",
            "largest / smallest slope",
        ],
    );
    for row in rows {
        let figures = [row.least, row.pooled, row.zeroed, row.clamped, row.centre].map(|r| Cell::figure(r, 3));
        let factor = Cell::figure(row.slope_factor, 1);
        table.row(row.law, [Cell::figure(row.distance_mm, 1)].into_iter().chain(figures).chain([factor]));
    }
    section.table(table);
    let best = rows.iter().max_by(|a, b| a.pooled.total_cmp(&b.pooled));
    if let Some(best) = best {
        let met = rows.iter().filter(|row| row.pooled >= published::POOLED_CORRELATION).count();
        section.text(format!(
            "The paper's {} is reached by {met} of {} combinations; the largest is {:.3}, with {} contact at {} mm. The zero level and \
             negative features have no effect: the largest feature of a press is never negative, and the density is normalised at rest. \
             The presses at the centre alone always lie on one line; the slopes differ between the places of the presses.",
            published::POOLED_CORRELATION,
            rows.len(),
            best.pooled,
            best.law,
            best.distance_mm
        ));
    }
    section
}

//! Figure 5: the density feature against depth, and the line through it.

use fingervision_calibrate::depth::DepthFit;
use fingervision_gel::Scene;
use serde::Serialize;

use super::{Lab, Setting, published};
use crate::benchmark::with_dots;
use crate::experiment::{ExperimentError, Following, Recording, calibrate};
use crate::page::{Cell, HtmlTable, Section};

/// The results of the nine presses of a sensor.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LawFit {
    /// The sensor.
    pub setting: Setting,
    /// The presses' names and correlations.
    pub correlations: Vec<(String, f64)>,
    /// Correlation of all together.
    pub pooled: f64,
    /// Slope of the pooled line, mm.
    pub slope_mm: f64,
    /// Its intercept, mm.
    pub intercept_mm: f64,
    /// The steepest press's slope over the flattest one's.
    pub slope_factor: f64,
    /// Correlation of all together, tracked with 15×15 dots.
    pub dots_pooled: f64,
}

/// The fits of the dense pattern and of dots.
pub(super) struct Fits {
    pub(super) dense: DepthFit,
    pub(super) dots: DepthFit,
}

pub(super) fn measure(lab: &Lab, setting: Setting) -> Result<(Fits, LawFit, Section), ExperimentError> {
    let on_sensor = |scene: Scene| Recording::of(&setting.draft(scene, lab.extent)?, lab.cache);
    let on_dots = |scene: Scene| Recording::of(&with_dots(setting.draft(scene, lab.extent)?)?, lab.cache);
    let dense = calibrate(&on_sensor, Following::Dense)?;
    let dots = calibrate(&on_dots, Following::Dots)?;
    let law = LawFit {
        setting,
        correlations: dense.presses.iter().map(|press| (press.curve.name.clone(), press.line.correlation)).collect(),
        pooled: dense.pooled.correlation,
        slope_mm: dense.pooled.slope,
        intercept_mm: dense.pooled.intercept,
        slope_factor: dense.slope_factor,
        dots_pooled: dots.pooled.correlation,
    };
    let section = section(setting, &setting.about(lab.extent)?, &dense, &law)?;
    Ok((Fits { dense, dots }, law, section))
}

fn section(setting: Setting, about: &str, fit: &DepthFit, law: &LawFit) -> Result<Section, ExperimentError> {
    let mut section = Section::new(
        &format!("law-{}", setting.word()),
        format!("Figure 5: density against depth, {}", setting.name()),
    );
    section.text(format!("Nine presses of a 6 mm square, 1, 2 and 3 mm deep, tracked from images: {about}."));
    section.picture(
        &fit.draw(),
        "The largest density feature of every frame against the known depth, and the pooled lines.",
    )?;
    let mut table = HtmlTable::new(
        "A line fitted to each press: depth = slope · feature + intercept",
        ["press", "correlation", "slope, mm", "intercept, mm"],
    );
    for press in &fit.presses {
        let line = &press.line;
        let figures = [Cell::figure(line.correlation, 4), Cell::figure(line.slope, 1), Cell::figure(line.intercept, 2)];
        table.row(press.curve.name.as_str(), figures);
    }
    let pooled = [Cell::figure(law.pooled, 4), Cell::figure(law.slope_mm, 1), Cell::figure(law.intercept_mm, 2)];
    table.row("all nine together", pooled);
    section.table(table);
    let least = law.correlations.iter().map(|(_, r)| *r).fold(1.0, f64::min);
    section.text(format!(
        "Paper: each press above {}, all together {}. Here: each {least:.3} or above, all together {:.2}; the slopes differ by a \
         factor of {:.1}. Where a curve has a step, the flow at the rim is no longer valid because the surface expands too much, and \
         the maximum moves from the rim to the face: calibrate depth --maximum robust leaves the rim out. What the correlation of all \
         presses together depends on is shown below.",
        published::EACH_CORRELATION,
        published::POOLED_CORRELATION,
        law.pooled,
        law.slope_factor
    ));
    for warning in &fit.warnings {
        section.warning(warning.as_str());
    }
    Ok(section)
}

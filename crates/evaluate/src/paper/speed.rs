//! Frame rate.

use fingervision_gel::Scene;
use serde::Serialize;

use super::{Lab, Setting, published};
use crate::end_point::quantile;
use crate::experiment::{ExperimentError, Following, Recording, follow};
use crate::page::{Cell, HtmlTable, Section};

/// Time from an image's arrival to its density feature, on one thread.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Speed {
    /// Columns and rows, px.
    pub size: (usize, usize),
    /// Median over the frames, ms.
    pub median_ms: f64,
    /// 95th percentile, ms.
    pub percentile_95_ms: f64,
}

pub(super) fn measure(lab: &Lab) -> Result<(Speed, Section), ExperimentError> {
    let recording = Recording::of(&Setting::Realistic.scene(Scene::find("circle")?, lab.extent)?, lab.cache)?;
    let mut times = Vec::new();
    follow(&recording, &recording.profile, Following::Dense, |_, found| times.push(found.latency_ms as f32))?;
    let [median_ms, percentile_95_ms] = [0.5, 0.95].map(|part| quantile(times.iter().copied(), part));
    let speed = Speed { size: recording.size(), median_ms, percentile_95_ms };
    let mut section = Section::new("speed", "Frame rate");
    let mut table = HtmlTable::new("From image to filtered density", ["", "size, px", "ms per frame", "frames/s"]);
    let (width, height) = speed.size;
    let size = Cell::text(format!("{width}×{height}"));
    table.row(
        "median, this machine, one thread",
        [size.clone(), Cell::figure(speed.median_ms, 1), Cell::figure(1e3 / speed.median_ms, 0)],
    );
    table.row(
        "95 % within",
        [size, Cell::figure(speed.percentile_95_ms, 1), Cell::figure(1e3 / speed.percentile_95_ms, 0)],
    );
    let published_ms = Cell::figure(1e3 / published::FRAMES_PER_SECOND, 1);
    table.row(
        "paper, i7-7700K and GTX 1060",
        [Cell::text("610×450"), published_ms, Cell::figure(published::FRAMES_PER_SECOND, 0)],
    );
    section.table(table);
    section.text(
        "The paper uses a graphics processor. Here every kernel uses the processor's vector instructions, the gradients of the template \
         are computed once per reference, and every frame starts from the flow of the previous one.",
    );
    Ok((speed, section))
}

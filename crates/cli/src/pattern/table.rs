//! The table of predicted noise.

use std::fmt;

use fingervision_gel::{Trackability, View};
use serde::Serialize;

/// A deviation up to this factor above the least one counts as nearly as good.
const NEARLY: f64 = 1.05;

/// A size with its predicted noise.
#[derive(Debug, Serialize)]
pub(super) struct Row {
    /// Side of a cell or diameter of a disc, mm.
    part_mm: f64,
    #[serde(flatten)]
    score: Trackability,
    /// Predicted standard deviation of the tracker's flow to the right and downwards, px.
    flow_deviation_px: Option<[f64; 2]>,
}

/// All sizes.
#[derive(Debug, Serialize)]
pub(super) struct Table {
    kind: &'static str,
    image_px: [usize; 2],
    gel_mm: [f64; 2],
    /// In the middle of the image.
    mm_per_px: Option<f64>,
    blur_px: f64,
    noise_levels: f64,
    colour: bool,
    rows: Vec<Row>,
    /// The requested size, mm.
    asked_part_mm: Option<f64>,
    /// The size with the least deviation, mm.
    best_part_mm: Option<f64>,
    /// Least and largest size whose deviation is at most a twentieth larger, mm.
    good_part_mm: Option<[f64; 2]>,
}

impl Row {
    pub(super) fn new(part_mm: f64, score: Trackability, flow_deviation_px: Option<[f64; 2]>) -> Self {
        Self { part_mm, score, flow_deviation_px }
    }

    /// Both components together: of the flow, or of a patch if the flow is not predicted.
    fn deviation_px(&self) -> f64 {
        let [u, v] = self.flow_deviation_px.unwrap_or(self.score.deviation_px);
        u.hypot(v)
    }
}

impl Table {
    pub(super) fn new(kind: &'static str, view: &View, rows: Vec<Row>, asked_part_mm: Option<f64>) -> Self {
        let middle = view.size_px.map(|size| 0.5 * (size as f64 - 1.0));
        let usable = rows.iter().filter(|row| row.deviation_px().is_finite());
        let best = usable.min_by(|a, b| a.deviation_px().total_cmp(&b.deviation_px()));
        Self {
            kind,
            image_px: view.size_px,
            gel_mm: view.gel_mm,
            mm_per_px: view.camera.mm_per_px(middle),
            blur_px: view.blur_px,
            noise_levels: view.noise_levels,
            colour: view.colour,
            asked_part_mm,
            best_part_mm: best.map(|row| row.part_mm),
            good_part_mm: best.and_then(|best| good_sizes(&rows, NEARLY * best.deviation_px())),
            rows,
        }
    }
}

/// Least and largest size whose deviation is at most this, mm.
fn good_sizes(rows: &[Row], most_px: f64) -> Option<[f64; 2]> {
    let mut good = rows.iter().filter(|row| row.deviation_px() <= most_px).map(|row| row.part_mm);
    let first = good.next()?;
    Some([first, good.next_back().unwrap_or(first)])
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { image_px: [width, height], gel_mm: [gel_width, gel_height], .. } = self;
        let camera = if self.colour { "colour" } else { "grey" };
        write!(
            f,
            "camera  {width}x{height} px, {camera}, blur {} px, noise {} grey levels",
            self.blur_px, self.noise_levels
        )?;
        if let Some(scale) = self.mm_per_px {
            write!(f, ", {scale:.4} mm per px in the middle")?;
        }
        writeln!(f, "\ngel     {gel_width}x{gel_height} mm")?;
        writeln!(f, "kind    {}", self.kind)?;
        let part = if self.kind == "colour" { "cell" } else { "diameter" };
        writeln!(f, "\n{part:>8}           gradient   patch of 16 px alone           flow, predicted    poor")?;
        writeln!(f, "      mm     px   levels/px   u px     v px     u µm    v µm   u px     v px     patches")?;
        for row in &self.rows {
            row.fmt(f, self.mm_per_px)?;
        }
        match (self.best_part_mm, self.good_part_mm) {
            (Some(best), Some([least, most])) => {
                writeln!(f, "\nleast noise with a {part} of {best:.4} mm; {least:.4} to {most:.4} mm are within 5 %")?;
                self.write_asked(f, best)?;
                write!(
                    f,
                    "u and v: standard deviation of the displacement to the right and down; poor: patches above 0.1 px"
                )
            }
            _ => write!(f, "\nno size can be tracked with this camera"),
        }
    }
}

impl Table {
    /// The noise of the requested size compared with the best one.
    fn write_asked(&self, f: &mut fmt::Formatter<'_>, best_mm: f64) -> fmt::Result {
        let row = |part_mm: f64| self.rows.iter().find(|row| row.part_mm.total_cmp(&part_mm).is_eq());
        let Some(asked) = self.asked_part_mm.and_then(row) else { return Ok(()) };
        let (deviation_px, part_mm) = (asked.deviation_px(), asked.part_mm);
        match row(best_mm) {
            Some(best) if deviation_px.is_finite() => {
                let more = 100.0 * (deviation_px / best.deviation_px() - 1.0);
                writeln!(
                    f,
                    "requested: {part_mm:.4} mm, {deviation_px:.5} px in both directions, {more:.0} % above the least"
                )
            }
            _ => writeln!(f, "requested: {part_mm:.4} mm, which cannot be tracked with this camera"),
        }
    }
}

impl Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>, mm_per_px: Option<f64>) -> fmt::Result {
        let Self { part_mm, score, flow_deviation_px } = self;
        let px = mm_per_px.map_or_else(String::new, |scale| format!("{:.2}", part_mm / scale));
        let [u, v] = score.deviation_px.map(|px| format!("{px:.5}"));
        let [u_um, v_um] = score.deviation_mm.map(|mm| format!("{:.3}", 1e3 * mm));
        let [flow_u, flow_v] = flow_deviation_px.map_or_else(Default::default, |px| px.map(|px| format!("{px:.5}")));
        write!(f, "{part_mm:8.4} {px:>6} {:10.1}   {u:<8} {v:<8} {u_um:<7} {v_um:<6}", score.gradient_levels_per_px)?;
        writeln!(f, " {flow_u:<8} {flow_v:<8} {:4.0} %", 100.0 * score.poor)
    }
}

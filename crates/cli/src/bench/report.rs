//! The results of `fingervision bench`.

use std::fmt;

use fearless_simd::Level;
use fingervision_gel::Motion;
use fingervision_image::{Image, Rect};
use serde::Serialize;

use crate::doctor::instruction_set;

/// Border excluded from the error on each side, px.
const BORDER_PX: usize = 16;

/// Times and errors of the frames after the reference.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    /// Columns and rows that are tracked, px.
    size: (usize, usize),
    /// The largest displacement of the press, px.
    press_px: f64,
    instruction_set: String,
    /// Number of timed frames.
    frames: usize,
    frame_ms: Times,
    /// Frames over their total time.
    frames_per_second: f64,
    epe_px: Errors,
    /// Absent for a user's own profile.
    elastic_ms: Option<ElasticTimes>,
}

/// Additional time of depth from elasticity, ms: differences of medians.
#[derive(Debug, Serialize)]
pub(super) struct ElasticTimes {
    /// The median time of flow alone.
    flow: f64,
    live: f64,
    exact: f64,
}

/// Percentiles of the times, ms.
#[derive(Debug, Serialize)]
struct Times {
    median: f64,
    p10: f64,
    p50: f64,
    p90: f64,
    p99: f64,
    max: f64,
}

/// Mean end-point errors, px.
#[derive(Debug, Serialize)]
struct Errors {
    /// Of all frames.
    mean: f64,
    /// Of the last one.
    #[serde(rename = "final")]
    last: f64,
}

impl Report {
    /// `times_ms` and `errors_px` contain at least one value each.
    pub(super) fn new(
        size: (usize, usize),
        press_px: f64,
        mut times_ms: Vec<f64>,
        errors_px: &[f64],
        elastic_ms: Option<ElasticTimes>,
    ) -> Self {
        times_ms.sort_by(f64::total_cmp);
        Self {
            size,
            press_px,
            instruction_set: instruction_set(Level::new()),
            frames: times_ms.len(),
            frame_ms: Times::new(&times_ms),
            frames_per_second: 1e3 / mean(&times_ms),
            epe_px: Errors { mean: mean(errors_px), last: errors_px[errors_px.len() - 1] },
            elastic_ms,
        }
    }
}

impl ElasticTimes {
    /// From the times of flow alone and of flow with depth in both modes, at least one each.
    pub(super) fn new(flow: Vec<f64>, live: Vec<f64>, exact: Vec<f64>) -> Self {
        let [flow, live, exact] = [flow, live, exact].map(|mut times_ms| {
            times_ms.sort_by(f64::total_cmp);
            percentile(&times_ms, 50.0)
        });
        Self { flow, live: live - flow, exact: exact - flow }
    }
}

impl Times {
    fn new(sorted: &[f64]) -> Self {
        let [median, p10, p90, p99, max] = [50.0, 10.0, 90.0, 99.0, 100.0].map(|percent| percentile(sorted, percent));
        Self { median, p10, p50: median, p90, p99, max }
    }
}

/// The value below which `percent` per cent of the values lie, linear between neighbours. `sorted` contains at least
/// one.
pub(super) fn percentile(sorted: &[f64], percent: f64) -> f64 {
    let rank = percent / 100.0 * (sorted.len() - 1) as f64;
    let (below, above) = (sorted[rank.floor() as usize], sorted[rank.ceil() as usize]);
    below + rank.fract() * (above - below)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Mean distance between the measured displacement `[u, v]` in a region of the image and the true one, valid or not,
/// px.
///
/// The border is excluded; NaN if nothing remains.
pub(super) fn end_point_error_px([u, v]: [&Image<f32>; 2], motion: &Motion, region: Rect) -> f64 {
    let inside = |length: usize| BORDER_PX..length.saturating_sub(BORDER_PX);
    let pixels = inside(region.height).flat_map(|y| inside(region.width).map(move |x| (x, y)));
    let (sum, count) = pixels.fold((0.0, 0.0), |(sum, count), (x, y)| {
        let (true_u, true_v) = motion.displacement((region.x + x) as f64, (region.y + y) as f64);
        let miss = (f64::from(u.at(x, y)) - true_u).hypot(f64::from(v.at(x, y)) - true_v);
        (sum + miss, count + 1.0)
    });
    sum / count
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { size: (width, height), press_px, instruction_set, frames, .. } = self;
        let Self { frame_ms, frames_per_second, epe_px, elastic_ms, .. } = self;
        let Times { p10, p50, p90, p99, max, .. } = frame_ms;
        let Errors { mean, last } = epe_px;
        writeln!(f, "{frames} frames of {width}x{height} px in colour, one thread, {instruction_set}")?;
        writeln!(f, "ms per frame     p10 {p10:.1}  p50 {p50:.1}  p90 {p90:.1}  p99 {p99:.1}  max {max:.1}")?;
        writeln!(f, "frames per second  {frames_per_second:.1}")?;
        writeln!(
            f,
            "flow error       {mean:.4} px on average, {last:.4} px at the end of the press of {press_px:.0} px"
        )?;
        elastic_ms.iter().try_for_each(|ElasticTimes { flow, live, exact }| {
            writeln!(f, "depth from elasticity adds  {live:.1} ms live, {exact:.1} ms exact to {flow:.1} ms of flow")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_percentile_lies_between_its_neighbours() {
        let times: Vec<f64> = (0..=200).map(f64::from).collect();
        for (percent, expected) in [(10.0, 20.0), (50.0, 100.0), (99.0, 198.0), (100.0, 200.0)] {
            let time = percentile(&times, percent);
            assert!((time - expected).abs() < 1e-9, "p{percent} is {time}, expected {expected}");
        }
        assert!((percentile(&[1.0, 2.0], 50.0) - 1.5).abs() < 1e-12);
        assert!((percentile(&[7.0], 99.0) - 7.0).abs() < 1e-12);
    }

    #[test]
    fn an_error_is_taken_inside_the_border_of_its_region() {
        let region = Rect { x: 5, y: 7, width: 40, height: 36 };
        let motion = Motion::radial_bump([30.0, 20.0], 6.0);
        let miss = |x: usize, y: usize| {
            if (16..24).contains(&x) && (16..20).contains(&y) { 5.0 } else { 100.0 }
        };
        let displacement = |x: usize, y: usize| motion.displacement((x + region.x) as f64, (y + region.y) as f64);
        let u = Image::from_fn(40, 36, |x, y| (displacement(x, y).0 + 0.6 * miss(x, y)) as f32);
        let v = Image::from_fn(40, 36, |x, y| (displacement(x, y).1 - 0.8 * miss(x, y)) as f32);
        let error = end_point_error_px([&u, &v], &motion, region);
        assert!((error - 5.0).abs() < 1e-5, "{error} px, expected 5 px");
    }
}

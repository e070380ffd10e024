//! The course of a run: the numbers of each reading over time, in bounded memory.

use fingervision_plot::{Rgb, TimePlot, TimePlots, Trend};
use fingervision_touch::{Flag, Reading};

/// Distinguishable with any kind of colour vision. Okabe and Ito, "Color Universal Design", 2008.
const BLUE: Rgb = [0, 114, 178];
const ORANGE: Rgb = [213, 94, 0];
/// Least value at the top of each plot: noise must not look like touch.
const LEAST_FLOW_PX: f32 = 0.05;
const LEAST_DEPTH_MM: f32 = 0.05;
const LEAST_FORCE_N: f32 = 0.05;

/// Mean flow, depth, normal and shear force over the frames of a run.
#[derive(Debug)]
pub(super) struct Course {
    flow_px: Trend,
    depth_mm: Trend,
    normal_n: Trend,
    shear_n: Trend,
}

impl Course {
    pub(super) fn new() -> Self {
        Self { flow_px: Trend::new(), depth_mm: Trend::new(), normal_n: Trend::new(), shear_n: Trend::new() }
    }

    /// Takes the numbers of the next reading; a frame that lost track has none.
    pub(super) fn push(&mut self, reading: &Reading, mean_flow_px: f32) {
        let time_s = reading.capture_time_s;
        let is_lost = reading.flags.has(Flag::Lost);
        let known = |value: Option<f32>| value.filter(|_| !is_lost).unwrap_or(f32::NAN);
        self.flow_px.push(time_s, mean_flow_px);
        self.depth_mm.push(time_s, known(reading.max_depth_mm));
        self.normal_n.push(time_s, known(reading.force_n.map(|[_, _, normal]| normal)));
        self.shear_n.push(time_s, known(reading.force_n.map(|[x, y, _]| x.hypot(y))));
    }

    /// Frames taken so far.
    pub(super) fn frames(&self) -> u64 {
        self.flow_px.frames()
    }

    /// Time of the first frame on the source's clock, s.
    pub(super) fn start_s(&self) -> f64 {
        self.flow_px.start_s()
    }

    /// A plot for each quantity that is known, the flow first.
    pub(super) fn plots(&self) -> TimePlots<'_> {
        let plot = |heading, least_top, lines| TimePlot { heading, least_top, lines };
        let flow = vec![("", BLUE, self.flow_px.steps())];
        let depth = vec![("", BLUE, self.depth_mm.steps())];
        let force = vec![("normal", BLUE, self.normal_n.steps()), ("shear", ORANGE, self.shear_n.steps())];
        let mut plots = vec![
            plot("Mean flow over valid pixels, px", LEAST_FLOW_PX, flow),
            plot("Depth of the deepest pixel, mm", LEAST_DEPTH_MM, depth),
            plot("Force, N", LEAST_FORCE_N, force),
        ];
        let is_known =
            |plot: &TimePlot| plot.lines.iter().any(|(_, _, steps)| steps.iter().any(|step| step.peak.is_finite()));
        let mut place = 0;
        plots.retain(|plot| {
            place += 1;
            place == 1 || is_known(plot)
        });
        let last_s = self.flow_px.steps().last().map_or(0.0, |step| step.time_s);
        TimePlots { plots, frames: self.frames(), last_s }
    }
}

//! The strip below the panels: mean flow over time, so that press and release are seen at a glance.

use super::Rgb;
use super::axes::Axes;
use super::canvas::{Area, Canvas, Point};
use super::page::HEADING;
use super::ticks::round_up;
use super::trend::{Step, Trend};

const LINE: Rgb = [25, 103, 210];
const UNDER_LINE: Rgb = [222, 234, 250];
const MARK: Rgb = [217, 119, 6];
/// For the numbers on the vertical axis, px.
const LABELS: f32 = 56.0;
/// Flow at the top of the plot at least, px: noise shall not look like touch.
const LEAST_TOP_PX: f32 = 0.05;

/// Draws the plot with heading and labels into an area and marks the frame that the panels show.
pub(super) fn draw(canvas: &mut Canvas, area: Area, trend: &Trend, shown_frame: u64) {
    canvas.text("Mean flow over valid pixels, px", (area.x, area.y + 16.0), HEADING);
    let frame = Area { x: area.x + LABELS, y: area.y + 52.0, width: area.width - LABELS, height: area.height - 104.0 };
    let plot = Plot::new(frame, trend);
    plot.axes.draw(canvas);
    for run in trend.steps().split(|step| step.peak.is_nan()) {
        plot.draw_run(canvas, run);
    }
    let shown = trend.steps().iter().rev().find(|step| step.frame <= shown_frame);
    if let Some(shown) = shown {
        plot.draw_mark(canvas, *shown);
    }
}

/// Time on the horizontal axis; frames where the source's clock stands still.
struct Plot {
    axes: Axes,
}

impl Plot {
    fn new(area: Area, trend: &Trend) -> Self {
        let peaks = trend.steps().iter().map(|step| step.peak);
        let top = round_up(peaks.fold(LEAST_TOP_PX, f32::max));
        let last_s = trend.steps().last().map_or(0.0, |step| step.time_s);
        let counts_frames = last_s <= 0.0;
        let last = if counts_frames { trend.frames().saturating_sub(1).max(1) as f64 } else { last_s };
        Self { axes: Axes { area, top, last, counts_frames } }
    }

    fn place(&self, step: Step) -> Point {
        let along = if self.axes.counts_frames { step.frame as f64 } else { step.time_s };
        self.axes.place(along, step.peak)
    }

    /// Draws steps between two gaps.
    fn draw_run(&self, canvas: &mut Canvas, run: &[Step]) {
        let points: Vec<Point> = run.iter().map(|step| self.place(*step)).collect();
        match points[..] {
            [] => {}
            [point] => canvas.disc(point, 2.0, LINE),
            [first, .., last] => {
                let ground = |point: Point| (point.0, self.axes.area.bottom());
                let under: Vec<Point> = [ground(first)].iter().chain(&points).chain(&[ground(last)]).copied().collect();
                canvas.polygon(&under, UNDER_LINE);
                canvas.line(&points, 2.0, LINE);
            }
        }
    }

    fn draw_mark(&self, canvas: &mut Canvas, shown: Step) {
        let (x, y) = self.place(shown);
        self.axes.draw_mark(canvas, x, MARK);
        if y.is_finite() {
            canvas.disc((x, y), 5.0, MARK);
        }
    }
}

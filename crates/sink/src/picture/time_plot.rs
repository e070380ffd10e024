//! The strip below the panels: mean flow over time, so that press and release are seen at a glance.

use super::Rgb;
use super::canvas::{Area, Canvas, Point};
use super::page::{BODY, HEADING, NOTE};
use super::text::Anchor;
use super::ticks::{round_up, ticks};
use super::trend::{Step, Trend};

const LINE: Rgb = [25, 103, 210];
const UNDER_LINE: Rgb = [222, 234, 250];
const GRID: Rgb = [224; 3];
const AXIS: Rgb = [60, 64, 67];
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
    plot.draw_axes(canvas);
    for run in trend.steps().split(|step| step.peak.is_nan()) {
        plot.draw_run(canvas, run);
    }
    let shown = trend.steps().iter().rev().find(|step| step.frame <= shown_frame);
    if let Some(shown) = shown {
        plot.draw_mark(canvas, *shown);
    }
}

/// A plot area and the numbers at its edges.
struct Plot {
    area: Area,
    top: f32,
    last: f64,
    /// Time on the horizontal axis; frames where the source's clock stands still.
    is_timed: bool,
}

impl Plot {
    fn new(area: Area, trend: &Trend) -> Self {
        let peaks = trend.steps().iter().map(|step| step.peak);
        let top = round_up(peaks.fold(LEAST_TOP_PX, f32::max));
        let last_s = trend.steps().last().map_or(0.0, |step| step.time_s);
        let is_timed = last_s > 0.0;
        let last = if is_timed { last_s } else { trend.frames().saturating_sub(1).max(1) as f64 };
        Self { area, top, last, is_timed }
    }

    fn place(&self, step: Step) -> Point {
        let along = if self.is_timed { step.time_s } else { step.frame as f64 };
        let along = (along / self.last).clamp(0.0, 1.0) as f32;
        (self.area.x + along * self.area.width, self.area.bottom() - step.peak / self.top * self.area.height)
    }

    fn draw_axes(&self, canvas: &mut Canvas) {
        let Area { x, .. } = self.area;
        let (right, bottom) = (self.area.right(), self.area.bottom());
        for (value, label) in ticks(0.0, self.top, 4) {
            let y = bottom - value / self.top * self.area.height;
            canvas.line(&[(x, y), (right, y)], 1.0, GRID);
            canvas.text(&label, (x - 10.0, y + 5.5), BODY.anchored(Anchor::Right));
        }
        // There is no half frame.
        let most = if self.is_timed { 12 } else { self.last.min(12.0) as usize };
        for (value, label) in ticks(0.0, self.last as f32, most) {
            let tick = x + value / self.last as f32 * self.area.width;
            canvas.line(&[(tick, bottom), (tick, bottom + 5.0)], 1.0, AXIS);
            let text = tick.min(right - BODY.width(&label) / 2.0);
            canvas.text(&label, (text, bottom + 23.0), BODY.anchored(Anchor::Centre));
        }
        let name = if self.is_timed { "Time since the first frame, s" } else { "Frame, counted from 0" };
        canvas.text(name, (right, bottom + 48.0), NOTE.anchored(Anchor::Right));
    }

    /// Draws steps between two gaps.
    fn draw_run(&self, canvas: &mut Canvas, run: &[Step]) {
        let points: Vec<Point> = run.iter().map(|step| self.place(*step)).collect();
        match points[..] {
            [] => {}
            [point] => canvas.disc(point, 2.0, LINE),
            [first, .., last] => {
                let ground = |point: Point| (point.0, self.area.bottom());
                let under: Vec<Point> = [ground(first)].iter().chain(&points).chain(&[ground(last)]).copied().collect();
                canvas.polygon(&under, UNDER_LINE);
                canvas.line(&points, 2.0, LINE);
            }
        }
    }

    fn draw_mark(&self, canvas: &mut Canvas, shown: Step) {
        let (x, y) = self.place(shown);
        canvas.line(&[(x, self.area.y - 10.0), (x, self.area.bottom())], 1.5, MARK);
        if y.is_finite() {
            canvas.disc((x, y), 5.0, MARK);
        }
        let text = "the frame above";
        let half = BODY.width(text) / 2.0;
        let middle = x.clamp(self.area.x + half, self.area.right() - half);
        let style = super::text::Style { colour: MARK, anchor: Anchor::Centre, ..BODY };
        canvas.text(text, (middle, self.area.y - 16.0), style);
    }
}

//! The strip below the panels: flow, depth and force over time, which shows press and release.

use crate::axes::Axes;
use crate::canvas::{Area, Canvas, Point};
use crate::colour::Rgb;
use crate::page::{BODY, GAP, HEADING};
use crate::ticks::round_up;
use crate::trend::Step;

const MARK: Rgb = [120; 3];
/// For the numbers on the vertical axis, px.
const LABELS: f32 = 56.0;
/// From the top of the area to the plot, and from the plot to its bottom, px.
const HEAD: f32 = 52.0;
const FOOT: f32 = 52.0;

/// Lines that share a pair of axes.
#[derive(Debug)]
pub struct TimePlot<'a> {
    /// The quantity, with its unit.
    pub heading: &'static str,
    /// Least number at the upper edge.
    pub least_top: f32,
    /// Name, colour and numbers; a plot of one line needs no name.
    pub lines: Vec<(&'static str, Rgb, &'a [Step])>,
}

/// Plots side by side that share their horizontal axis.
#[derive(Debug)]
pub struct TimePlots<'a> {
    /// From left to right.
    pub plots: Vec<TimePlot<'a>>,
    /// Frames of the run so far.
    pub frames: u64,
    /// The time of the last step since the first frame, s.
    pub last_s: f64,
}

impl TimePlots<'_> {
    /// Draws them into an area; `shown_frame` is marked if the panels above show one of many.
    pub fn draw(&self, canvas: &mut Canvas, area: Area, shown_frame: Option<u64>) {
        let width = (area.width + GAP) / self.plots.len() as f32 - GAP;
        for (place, plot) in self.plots.iter().enumerate() {
            let x = area.x + place as f32 * (width + GAP);
            self.draw_plot(canvas, Area { x, width, ..area }, plot, shown_frame);
        }
    }

    fn draw_plot(&self, canvas: &mut Canvas, area: Area, plot: &TimePlot, shown_frame: Option<u64>) {
        canvas.text(plot.heading, (area.x, area.y + 16.0), HEADING);
        draw_names(canvas, (area.x + HEADING.width(plot.heading) + 28.0, area.y + 16.0), plot);
        let place = Area {
            x: area.x + LABELS,
            y: area.y + HEAD,
            width: area.width - LABELS,
            height: area.height - HEAD - FOOT,
        };
        let axes = self.axes(place, plot);
        axes.draw(canvas);
        let at = |step: Step| axes.place(if axes.counts_frames { step.frame as f64 } else { step.time_s }, step.peak);
        for (_, colour, steps) in &plot.lines {
            for run in steps.split(|step| step.peak.is_nan()) {
                let points: Vec<Point> = run.iter().map(|step| at(*step)).collect();
                match points[..] {
                    [] => {}
                    [point] => canvas.disc(point, 2.0, *colour),
                    _ => canvas.line(&points, 2.0, *colour),
                }
            }
        }
        let Some(shown_frame) = shown_frame else { return };
        for (number, (_, colour, steps)) in plot.lines.iter().enumerate() {
            let Some(shown) = steps.iter().rev().find(|step| step.frame <= shown_frame) else { continue };
            let (x, y) = at(*shown);
            if number == 0 {
                axes.draw_mark(canvas, x, MARK);
            }
            if y.is_finite() {
                canvas.disc((x, y), 5.0, *colour);
            }
        }
    }

    /// Time on the horizontal axis; frames where the source's clock stands still.
    fn axes(&self, area: Area, plot: &TimePlot) -> Axes {
        let values = || plot.lines.iter().flat_map(|(_, _, steps)| *steps).map(|step| step.peak);
        let top = round_up(values().fold(plot.least_top, f32::max));
        let lowest = values().fold(0.0, f32::min);
        // What rounding or noise puts just below zero makes no room of its own.
        let low = if lowest < -0.02 * top { -round_up(-lowest) } else { 0.0 };
        let last_s = self.last_s;
        let counts_frames = last_s <= 0.0;
        let last = if counts_frames { self.frames.saturating_sub(1).max(1) as f64 } else { last_s };
        Axes { area, low, top, last, counts_frames }
    }
}

/// Draws the names of the lines, after the heading.
fn draw_names(canvas: &mut Canvas, (mut x, y): Point, plot: &TimePlot) {
    for (name, colour, _) in plot.lines.iter().filter(|(name, ..)| !name.is_empty()) {
        canvas.line(&[(x, y - 5.0), (x + 24.0, y - 5.0)], 2.5, *colour);
        canvas.text(name, (x + 34.0, y), BODY);
        x += 34.0 + BODY.width(name) + 24.0;
    }
}

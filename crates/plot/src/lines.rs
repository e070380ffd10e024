//! A few numbers over frames: lines with their names.

use crate::axes::Axes;
use crate::canvas::{Area, Canvas, Point};
use crate::colour::Rgb;
use crate::page::{BODY, HEADING};
use crate::ticks::round_up;

/// Distinguishable with any kind of colour vision. Okabe and Ito, "Color Universal Design", 2008.
const COLOURS: [Rgb; 4] = [[0, 114, 178], [213, 94, 0], [0, 158, 115], [86, 86, 86]];
const MARK: Rgb = [120; 3];
/// For the numbers on the vertical axis, px.
const LABELS: f32 = 56.0;

/// Some numbers of one kind, none of them negative, over the frames of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct FramePlot {
    /// The quantity, with its unit.
    pub heading: String,
    /// Up to four lines: the name of each and its value in every frame, NaN where a frame has none.
    pub lines: Vec<(String, Vec<f32>)>,
}

impl FramePlot {
    /// Draws a plot with heading, names and axes into an area and marks the frame that is shown above.
    pub fn draw(&self, canvas: &mut Canvas, area: Area, shown_frame: usize) {
        canvas.text(&self.heading, (area.x, area.y + 16.0), HEADING);
        draw_names(canvas, (area.x + LABELS, area.y + 46.0), self);
        let values = || self.lines.iter().flat_map(|(_, values)| values).copied().filter(|value| value.is_finite());
        let frames = self.lines.iter().map(|(_, values)| values.len()).max().unwrap_or(0);
        let axes = Axes {
            area: Area {
                x: area.x + LABELS,
                y: area.y + 92.0,
                width: area.width - LABELS,
                height: area.height - 144.0,
            },
            low: 0.0,
            top: round_up(values().fold(0.0, f32::max)),
            last: frames.saturating_sub(1).max(1) as f64,
            counts_frames: true,
        };
        axes.draw(canvas);
        let (x, _) = axes.place(shown_frame as f64, 0.0);
        axes.draw_mark(canvas, x, MARK);
        for ((_, values), colour) in self.lines.iter().zip(COLOURS) {
            draw_line(canvas, &axes, values, colour);
        }
    }
}

fn draw_names(canvas: &mut Canvas, (mut x, y): Point, plot: &FramePlot) {
    for ((name, _), colour) in plot.lines.iter().zip(COLOURS) {
        canvas.line(&[(x, y - 5.0), (x + 24.0, y - 5.0)], 2.5, colour);
        canvas.text(name, (x + 34.0, y), BODY);
        x += 34.0 + BODY.width(name) + 32.0;
    }
}

/// A line with a gap at every frame that has no value; a value between two gaps is a dot.
fn draw_line(canvas: &mut Canvas, axes: &Axes, values: &[f32], colour: Rgb) {
    let points: Vec<(Point, bool)> =
        values.iter().enumerate().map(|(frame, &value)| (axes.place(frame as f64, value), value.is_finite())).collect();
    for run in points.split(|(_, is_there)| !is_there) {
        let run: Vec<Point> = run.iter().map(|(point, _)| *point).collect();
        match run[..] {
            [point] => canvas.disc(point, 2.5, colour),
            _ => canvas.line(&run, 2.0, colour),
        }
    }
}

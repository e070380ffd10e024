//! Curves over a common scale, side by side, each panel with its names below.

use fingervision_image::Image;

use crate::canvas::{Area, Canvas, Point};
use crate::colour::Rgb;
use crate::page::{BACKGROUND, BODY, COLUMN, GAP, HEADING, MARGIN, NOTE, TITLE};
use crate::text::Anchor;
use crate::ticks::{round_up, ticks};

/// Distinguishable with any kind of colour vision. Okabe and Ito, "Color Universal Design", 2008.
const COLOURS: [Rgb; 6] = [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [230, 159, 0], [86, 180, 233]];
const LINES: [Rgb; 3] = [[32, 33, 36], [140; 3], [190; 3]];
const GRID: Rgb = [224; 3];
const AXIS: Rgb = [60, 64, 67];
const TOP: f32 = 150.0;
const HEIGHT: f32 = 400.0;
/// For the numbers on the vertical axis, px.
const LABELS: f32 = 64.0;
/// Between two names, px.
const NAME_PITCH: f32 = 24.0;

/// Points that belong together, in order.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// The name.
    pub name: String,
    /// `[x, y]`; one that is not finite leaves a gap.
    pub points: Vec<[f64; 2]>,
}

/// A line through every panel: `y = slope · x + intercept`.
#[derive(Debug, Clone, PartialEq)]
pub struct StraightLine {
    /// The name.
    pub name: String,
    /// Change of y with x.
    pub slope: f64,
    /// y where x is 0.
    pub intercept: f64,
}

/// Curves in one pair of axes.
#[derive(Debug, Clone, PartialEq)]
pub struct CurvePanel {
    /// The heading.
    pub heading: String,
    /// Any number; after six the colours repeat.
    pub curves: Vec<Curve>,
}

/// Panels of curves side by side, all on one scale.
#[derive(Debug, Clone, PartialEq)]
pub struct CurvePlots {
    /// The first line.
    pub title: String,
    /// The line below.
    pub facts: String,
    /// The quantity on the horizontal axis, with its unit.
    pub x_name: String,
    /// The quantity on the vertical axis, with its unit.
    pub y_name: String,
    /// From left to right.
    pub panels: Vec<CurvePanel>,
    /// Up to three, drawn into every panel below the curves.
    pub lines: Vec<StraightLine>,
}

/// Positions of values in one panel.
struct Frame {
    area: Area,
    x: [f32; 2],
    y: [f32; 2],
}

impl CurvePlots {
    /// The picture, 520 px a panel.
    #[must_use]
    pub fn draw(&self) -> Image<Rgb> {
        let panels = self.panels.len().max(1) as f32;
        let rows = self.panels.iter().map(|panel| panel.curves.len()).max().unwrap_or(0) + self.lines.len();
        let width = 2.0 * MARGIN + panels * COLUMN + (panels - 1.0) * GAP;
        let height = TOP + HEIGHT + 84.0 + rows as f32 * NAME_PITCH + 16.0;
        let title = TITLE.width(&self.title).max(NOTE.width(&self.facts)) + 2.0 * MARGIN;
        let mut canvas = Canvas::new(width.max(title).ceil() as u32, height as u32, BACKGROUND);
        canvas.text(&self.title, (MARGIN, 60.0), TITLE);
        canvas.text(&self.facts, (MARGIN, 90.0), NOTE);
        let (x, y) = (self.range(0), self.range(1));
        for (place, panel) in self.panels.iter().enumerate() {
            let left = MARGIN + place as f32 * (COLUMN + GAP);
            canvas.text(&panel.heading, (left, TOP - 16.0), HEADING);
            let area = Area { x: left + LABELS, y: TOP, width: COLUMN - LABELS, height: HEIGHT };
            let frame = Frame { area, x, y };
            frame.draw_axes(&mut canvas, self);
            self.draw_lines(&mut canvas, &frame);
            for (curve, colour) in panel.curves.iter().zip(COLOURS.into_iter().cycle()) {
                frame.draw_curve(&mut canvas, &curve.points, colour);
            }
            self.draw_names(&mut canvas, panel, (left + LABELS, TOP + HEIGHT + 84.0));
        }
        canvas.into_image()
    }

    /// The scale of one coordinate: from zero, or from below it, to a round number.
    fn range(&self, coordinate: usize) -> [f32; 2] {
        let points = self.panels.iter().flat_map(|panel| &panel.curves).flat_map(|curve| &curve.points);
        let values = points.map(|point| point[coordinate] as f32).filter(|value| value.is_finite());
        let (low, high) = values.fold((0.0_f32, 0.0_f32), |(low, high), value| (low.min(value), high.max(value)));
        [if low < -0.02 * high { -round_up(-low) } else { 0.0 }, if high > 0.0 { round_up(high) } else { 1.0 }]
    }

    fn draw_lines(&self, canvas: &mut Canvas, frame: &Frame) {
        for (line, colour) in self.lines.iter().zip(LINES) {
            let value = |x: f32| (line.slope * f64::from(x) + line.intercept) as f32;
            // Cut at the border of the panel.
            let [low, high] = frame.y;
            let at = |y: f32| ((f64::from(y) - line.intercept) / line.slope) as f32;
            let (from, to) = if line.slope > 0.0 { (at(low), at(high)) } else { (at(high), at(low)) };
            let (from, to) = (frame.x[0].max(from), frame.x[1].min(to));
            if from < to {
                canvas.line(&[frame.place(from, value(from)), frame.place(to, value(to))], 1.5, colour);
            }
        }
    }

    fn draw_names(&self, canvas: &mut Canvas, panel: &CurvePanel, (x, mut y): Point) {
        let curves = panel.curves.iter().map(|curve| &curve.name).zip(COLOURS.into_iter().cycle());
        let lines = self.lines.iter().map(|line| &line.name).zip(LINES);
        for (name, colour) in curves.chain(lines) {
            canvas.line(&[(x, y - 5.0), (x + 24.0, y - 5.0)], 2.5, colour);
            canvas.text(name, (x + 34.0, y), BODY);
            y += NAME_PITCH;
        }
    }
}

impl Frame {
    fn place(&self, x: f32, y: f32) -> Point {
        let part = |value: f32, [low, high]: [f32; 2]| (value - low) / (high - low);
        (self.area.x + part(x, self.x) * self.area.width, self.area.bottom() - part(y, self.y) * self.area.height)
    }

    fn draw_axes(&self, canvas: &mut Canvas, plots: &CurvePlots) {
        let Area { x, y, .. } = self.area;
        let (right, bottom) = (self.area.right(), self.area.bottom());
        for (value, label) in ticks(self.y[0], self.y[1], 5) {
            let (_, at) = self.place(0.0, value);
            canvas.line(&[(x, at), (right, at)], 1.0, GRID);
            canvas.text(&label, (x - 10.0, at + 5.5), BODY.anchored(Anchor::Right));
        }
        for (value, label) in ticks(self.x[0], self.x[1], 6) {
            let (at, _) = self.place(value, 0.0);
            canvas.line(&[(at, y), (at, bottom)], 1.0, GRID);
            canvas.text(&label, (at, bottom + 23.0), BODY.anchored(Anchor::Centre));
        }
        let ((_, ground), (wall, _)) = (self.place(0.0, 0.0), self.place(0.0, 0.0));
        canvas.line(&[(x, ground), (right, ground)], 1.0, AXIS);
        canvas.line(&[(wall, y), (wall, bottom)], 1.0, AXIS);
        canvas.text(&plots.x_name, (right, bottom + 48.0), NOTE.anchored(Anchor::Right));
        canvas.text(&plots.y_name, (right, y - 16.0), NOTE.anchored(Anchor::Right));
    }

    /// A line with a dot at every point.
    fn draw_curve(&self, canvas: &mut Canvas, points: &[[f64; 2]], colour: Rgb) {
        for run in points.split(|point| !point.iter().all(|value| value.is_finite())) {
            let run: Vec<Point> = run.iter().map(|&[x, y]| self.place(x as f32, y as f32)).collect();
            canvas.line(&run, 2.0, colour);
            for &point in &run {
                canvas.disc(point, 3.0, colour);
            }
        }
    }
}

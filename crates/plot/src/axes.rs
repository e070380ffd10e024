//! The axes of a plot: a number over frames or time.

use crate::canvas::{Area, Canvas, Point};
use crate::colour::Rgb;
use crate::page::{BODY, NOTE};
use crate::text::{Anchor, Style};
use crate::ticks::ticks;

const GRID: Rgb = [224; 3];
const AXIS: Rgb = [60, 64, 67];
/// Least distance between numbers on the horizontal axis, px.
const LABEL_PITCH: f32 = 80.0;

/// A plot area and the numbers at its edges.
pub(crate) struct Axes {
    /// Without the labels.
    pub(crate) area: Area,
    /// The number at the lower edge: zero, or below it.
    pub(crate) low: f32,
    /// The number at the upper edge.
    pub(crate) top: f32,
    /// The value at the right edge of the horizontal axis; the left one is zero.
    pub(crate) last: f64,
    /// Frames on the horizontal axis, counted from zero, or seconds.
    pub(crate) counts_frames: bool,
}

impl Axes {
    /// The position of a value.
    pub(crate) fn place(&self, along: f64, value: f32) -> Point {
        let along = (along / self.last).clamp(0.0, 1.0) as f32;
        let up = (value - self.low) / (self.top - self.low);
        (self.area.x + along * self.area.width, self.area.bottom() - up * self.area.height)
    }

    pub(crate) fn draw(&self, canvas: &mut Canvas) {
        let Area { x, width, .. } = self.area;
        let (right, bottom) = (self.area.right(), self.area.bottom());
        for (value, label) in ticks(self.low, self.top, 4) {
            let (_, y) = self.place(0.0, value);
            let is_zero_inside = self.low < 0.0 && value.abs() < 1e-6 * self.top;
            canvas.line(&[(x, y), (right, y)], 1.0, if is_zero_inside { AXIS } else { GRID });
            canvas.text(&label, (x - 10.0, y + 5.5), BODY.anchored(Anchor::Right));
        }
        let room = (width / LABEL_PITCH).max(1.0) as usize;
        // There is no half frame.
        let most = if self.counts_frames { room.min(self.last as usize).max(1) } else { room };
        for (value, label) in ticks(0.0, self.last as f32, most) {
            let tick = x + value / self.last as f32 * width;
            canvas.line(&[(tick, bottom), (tick, bottom + 5.0)], 1.0, AXIS);
            let text = tick.min(right - BODY.width(&label) / 2.0);
            canvas.text(&label, (text, bottom + 23.0), BODY.anchored(Anchor::Centre));
        }
        let name = if self.counts_frames { "Frame, counted from 0" } else { "Time since the first frame, s" };
        canvas.text(name, (right, bottom + 48.0), NOTE.anchored(Anchor::Right));
    }

    /// Marks the frame that is shown in the panels above.
    pub(crate) fn draw_mark(&self, canvas: &mut Canvas, x: f32, colour: Rgb) {
        canvas.line(&[(x, self.area.y - 10.0), (x, self.area.bottom())], 1.5, colour);
        let text = "the frame above";
        let half = BODY.width(text) / 2.0;
        let middle = x.clamp(self.area.x + half, self.area.right() - half);
        canvas.text(text, (middle, self.area.y - 16.0), Style { colour, anchor: Anchor::Centre, ..BODY });
    }
}

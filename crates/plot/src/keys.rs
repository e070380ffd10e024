//! The keys in the legend of a panel, which explain its colours and lines.

use fingervision_image::Image;

use crate::canvas::{Area, Canvas, Point};
use crate::colour::{INVALID_COLOUR, Rgb};
use crate::flow_colours::colour_wheel;
use crate::heat_map::HeatScale;
use crate::page::{BACKGROUND, BODY, NOTE};
use crate::panel::Panel;
use crate::text::Anchor;
use crate::ticks::{plain, ticks};

/// Lines that measure or point.
pub const RULE: Rgb = [60, 64, 67];

/// The colour wheel and its meaning; returns where its text starts.
pub fn draw_wheel_key(canvas: &mut Canvas, panel: Panel, radius_px: f32) -> f32 {
    let Area { x, y, .. } = panel.legend;
    let diameter = 112.0;
    canvas.copy(&colour_wheel(diameter as usize, BACKGROUND), x as usize, y as usize);
    let (centre, rim) = (x + diameter / 2.0, x + diameter);
    let middle = y + diameter / 2.0;
    canvas.line(&[(centre, middle), (rim + 10.0, middle)], 1.5, RULE);
    canvas.disc((centre, middle), 2.5, RULE);
    let radius = format!("{} px", plain(radius_px));
    canvas.text(&radius, (rim + 16.0, middle + 6.0), BODY);

    let text = rim + 16.0 + BODY.width(&radius) + 28.0;
    let lines = ["Hue: direction of motion", "Strength of colour: length", "Darker: beyond the wheel"];
    for (number, line) in [0.0, 1.0, 2.0].into_iter().zip(lines) {
        canvas.text(line, (text, panel.line(number)), NOTE);
    }
    text
}

/// The colours of a scale with numbers below.
pub fn draw_colour_bar(canvas: &mut Canvas, bar: Area, scale: HeatScale) {
    let (last, range) = (bar.width - 1.0, scale.high - scale.low);
    let value = |x: usize| scale.low + range * x as f32 / last;
    let colours = Image::from_fn(bar.width as usize, bar.height as usize, |x, _| scale.colour(value(x)));
    canvas.copy(&colours, bar.x as usize, bar.y as usize);
    for (value, label) in ticks(scale.low, scale.high, 6) {
        let x = bar.x + 0.5 + (value - scale.low) / range * last;
        canvas.line(&[(x, bar.bottom()), (x, bar.bottom() + 5.0)], 1.0, RULE);
        // Labels at the ends stay within the column.
        let half = BODY.width(&label) / 2.0;
        let x = x.clamp(bar.x + half, bar.right() - half);
        canvas.text(&label, (x, bar.bottom() + 22.0), BODY.anchored(Anchor::Centre));
    }
}

/// Draws the key of the grey of invalid pixels, with its text on a baseline.
pub fn draw_invalid_key(canvas: &mut Canvas, (x, y): Point, text: &str) {
    canvas.rectangle(Area { x, y: y - 13.0, width: 22.0, height: 15.0 }, INVALID_COLOUR);
    canvas.text(text, (x + 32.0, y), NOTE);
}

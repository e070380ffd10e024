//! The three panels of a preview, each with its heading above and its legend below.

use fingervision_image::Image;

use super::canvas::{Area, Canvas, Point, resized};
use super::outline::{self, Outline};
use super::page::{BACKGROUND, BODY, HEADING, NOTE};
use super::strongest::{Quantity, Strongest};
use super::text::Anchor;
use super::ticks::{plain, round_up, step_below, ticks};
use super::{HeatScale, INVALID_COLOUR, Rgb, colour_wheel, flow_colours, heat_map};

const ARROW: Rgb = [255, 193, 7];
const HALO: Rgb = [20, 20, 20];
pub(super) const RULE: Rgb = [60, 64, 67];
const FRAME: Rgb = [200; 3];
/// Between the tails of arrows, px on the picture.
const ARROW_PITCH: f32 = 22.0;
/// Least flow with full colour or length, px: noise must not look like touch.
pub(super) const LEAST_FLOW_PX: f32 = 0.1;
/// From one line of text to the next, px.
const LINE: f32 = 24.0;

/// The position of a panel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Panel {
    pub(super) image: Area,
    pub(super) legend: Area,
    /// Px on the picture per px of the field.
    pub(super) scale: f32,
}

impl Panel {
    pub(super) fn put(self, canvas: &mut Canvas, heading: &str, image: &Image<Rgb>) {
        canvas.text(heading, (self.image.x, self.image.y - 14.0), HEADING);
        let Area { x, y, width, height } = self.image;
        // A thin frame: a field without motion is as white as the page.
        canvas.rectangle(Area { x: x - 1.0, y: y - 1.0, width: width + 2.0, height: height + 2.0 }, FRAME);
        canvas.copy(image, x as usize, y as usize);
    }

    /// The image at the panel's size.
    pub(super) fn fit(self, image: &Image<Rgb>) -> Image<Rgb> {
        resized(image, self.image.width as usize, self.image.height as usize)
    }

    /// The baseline of a line of text in the legend, counted from 0.
    pub(super) fn line(self, number: f32) -> f32 {
        self.legend.y + 16.0 + LINE * number
    }
}

/// The camera image with arrows, a scale bar and an arrow of known length.
pub(super) fn draw_arrows(canvas: &mut Canvas, panel: Panel, shown: &Strongest, mm_per_px: Option<f32>) {
    // Darkened, so that arrows are visible on any image.
    let dark = |level: f32| [(24.0 + 0.6 * level.clamp(0.0, 255.0)) as u8; 3];
    let grey = Image::from_fn(shown.grey.width(), shown.grey.height(), |x, y| dark(shown.grey.at(x, y)));
    let longest = shown.typical_flow_px().max(LEAST_FLOW_PX);
    let factor = step_below(1.6 * ARROW_PITCH / (longest * panel.scale)).max(1.0);

    let mut image = Canvas::of(&panel.fit(&grey));
    let arrows = arrows(shown, panel.scale, factor);
    for &(tail, tip) in &arrows {
        draw_arrow(&mut image, tail, tip, 3.4, HALO);
    }
    for &(tail, tip) in &arrows {
        draw_arrow(&mut image, tail, tip, 1.6, ARROW);
    }
    panel.put(canvas, "Camera image and flow", &image.into_image());
    draw_scale_bar(canvas, panel, mm_per_px);
    draw_arrow_key(canvas, panel, step_below(longest), factor);
}

/// Tail and tip of every arrow, px on the panel. The tail is the pixel at rest.
fn arrows(shown: &Strongest, scale: f32, factor: f32) -> Vec<(Point, Point)> {
    let pitch = (ARROW_PITCH / scale).round().max(1.0) as usize;
    let (width, height) = shown.flow.size();
    let grid = |size: usize| (pitch / 2..size).step_by(pitch);
    let places = grid(height).flat_map(|y| grid(width).map(move |x| (x, y)));
    let arrow = |(x, y)| {
        let tail = ((x as f32 + 0.5) * scale, (y as f32 + 0.5) * scale);
        let (u, v) = (shown.flow.u.at(x, y), shown.flow.v.at(x, y));
        (tail, (tail.0 + factor * scale * u, tail.1 + factor * scale * v))
    };
    let valid = places.filter(|&(x, y)| shown.valid.at(x, y) != 0).map(arrow);
    valid.filter(|&(_, (x, y))| x.is_finite() && y.is_finite()).collect()
}

/// An arrow, or a dot where it would be too short to show a direction.
fn draw_arrow(canvas: &mut Canvas, tail: Point, tip: Point, width: f32, colour: Rgb) {
    let (dx, dy) = (tip.0 - tail.0, tip.1 - tail.1);
    let length = dx.hypot(dy);
    if length < 3.0 {
        canvas.disc(tail, 0.65 * width, colour);
        return;
    }
    let (dx, dy) = (dx / length, dy / length);
    let head = (0.45 * length).min(7.0);
    let barb = |side: f32| (tip.0 - head * (dx + 0.55 * side * dy), tip.1 - head * (dy - 0.55 * side * dx));
    canvas.line(&[tail, tip], width, colour);
    canvas.line(&[barb(1.0), tip, barb(-1.0)], width, colour);
}

fn draw_scale_bar(canvas: &mut Canvas, panel: Panel, mm_per_px: Option<f32>) {
    let (units_per_px, unit) = mm_per_px.map_or((1.0, "px"), |mm| (mm, "mm on the gel"));
    let value = step_below(120.0 / panel.scale * units_per_px);
    let length = value / units_per_px * panel.scale;
    let (left, y) = (panel.legend.x + 1.0, panel.line(0.0) - 5.0);
    canvas.line(&[(left, y), (left + length, y)], 2.0, RULE);
    for x in [left, left + length] {
        canvas.line(&[(x, y - 5.0), (x, y + 5.0)], 2.0, RULE);
    }
    canvas.text(&format!("{} {unit}", plain(value)), (left + length + 12.0, y + 5.0), BODY);
}

/// An arrow that represents `flow_px`.
fn draw_arrow_key(canvas: &mut Canvas, panel: Panel, flow_px: f32, factor: f32) {
    let length = flow_px * factor * panel.scale;
    let (left, y) = (panel.legend.x + 2.0, panel.line(1.2) - 5.0);
    for (width, colour) in [(3.4, HALO), (1.6, ARROW)] {
        draw_arrow(canvas, (left, y), (left + length, y), width, colour);
    }
    let drawn = if factor > 1.0 { format!(", drawn {}× longer", plain(factor)) } else { String::new() };
    canvas.text(&format!("{} px of flow{drawn}", plain(flow_px)), (left + length + 12.0, y + 5.0), BODY);
    canvas.text("Each arrow starts where its point is at rest.", (panel.legend.x, panel.line(2.4)), NOTE);
}

/// The flow as colour, and the colour wheel.
pub(super) fn draw_flow(canvas: &mut Canvas, panel: Panel, shown: &Strongest) {
    let radius_px = round_up(shown.typical_flow_px().max(LEAST_FLOW_PX));
    let colours = flow_colours(&shown.flow, &shown.valid, radius_px);
    panel.put(canvas, "Flow", &panel.fit(&colours));
    let text = draw_wheel_key(canvas, panel, radius_px);
    draw_invalid_key(canvas, (text, panel.line(3.2)), "not valid");
}

/// The colour wheel and its meaning; returns where its text starts.
pub(super) fn draw_wheel_key(canvas: &mut Canvas, panel: Panel, radius_px: f32) -> f32 {
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

/// Depth, density feature or flow length, and its colour bar.
pub(super) fn draw_heat(canvas: &mut Canvas, panel: Panel, shown: &Strongest) {
    draw_heat_up_to(canvas, panel, shown, round_up(shown.typical_value()));
}

/// The same with colours that end at `limit`.
pub(super) fn draw_heat_up_to(canvas: &mut Canvas, panel: Panel, shown: &Strongest, limit: f32) {
    let (heading, scale, note) = match shown.quantity {
        Quantity::Depth => ("Depth, mm", HeatScale::around_zero(limit), "Red is pressed in, blue bulges out."),
        Quantity::Density => {
            let note = "Red is where the surface spreads, blue where it contracts.";
            ("Density feature, dimensionless", HeatScale::around_zero(limit), note)
        }
        Quantity::FlowLength => ("Length of the flow, px", HeatScale::from_zero(limit), "No depth was computed."),
    };
    panel.put(canvas, heading, &panel.fit(&heat_map(&shown.values, &shown.values_valid, scale)));
    draw_colour_bar(canvas, Area { height: 16.0, ..panel.legend }, scale);
    canvas.text(note, (panel.legend.x, panel.line(2.2)), NOTE);
    draw_invalid_key(canvas, (panel.legend.x, panel.line(3.4)), "not valid");
    if let Some(contact) = &shown.contact {
        Outline::of(contact).draw(canvas, panel);
        let key = (panel.legend.x + 150.0, panel.line(3.4));
        let text = outline::draw_key(canvas, key);
        canvas.text("contact", (text, key.1), NOTE);
    }
}

pub(super) fn draw_colour_bar(canvas: &mut Canvas, bar: Area, scale: HeatScale) {
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

pub(super) fn draw_invalid_key(canvas: &mut Canvas, (x, y): Point, text: &str) {
    canvas.rectangle(Area { x, y: y - 13.0, width: 22.0, height: 15.0 }, INVALID_COLOUR);
    canvas.text(text, (x + 32.0, y), NOTE);
}

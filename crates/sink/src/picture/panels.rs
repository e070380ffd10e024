//! The three panels of a preview, each with its heading above and its legend below.

use fingervision_image::Image;
use fingervision_plot::page::{BODY, NOTE};
use fingervision_plot::{
    Area, Canvas, HeatScale, LEAST_FLOW_PX, Outline, Panel, Point, RULE, Rgb, draw_colour_bar, draw_invalid_key,
    draw_outline_key, draw_wheel_key, flow_colours, heat_map, plain, round_up, step_below,
};

use super::strongest::{Quantity, Strongest};

const ARROW: Rgb = [255, 193, 7];
const HALO: Rgb = [20, 20, 20];
/// Between the tails of arrows, px on the picture.
const ARROW_PITCH: f32 = 22.0;

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

/// Depth, density feature or flow length, and its colour bar.
pub(super) fn draw_heat(canvas: &mut Canvas, panel: Panel, shown: &Strongest) {
    draw_heat_up_to(canvas, panel, shown, shown.colour_end());
}

/// The same with colours that end at `limit`.
pub(super) fn draw_heat_up_to(canvas: &mut Canvas, panel: Panel, shown: &Strongest, limit: f32) {
    let (heading, scale, note) = match shown.quantity {
        Quantity::Depth => ("Depth, mm", HeatScale::around_zero(limit), "Red is pressed in, blue bulges out."),
        Quantity::Density => {
            let note = "Red is where the surface expands, blue where it contracts.";
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
        let text = draw_outline_key(canvas, key);
        canvas.text("contact", (text, key.1), NOTE);
    }
}

//! Lays out the preview: title, three panels with their legends, the plots over time.

use fingervision_image::Image;

use super::Rgb;
use super::canvas::{Area, Canvas};
use super::course::Course;
use super::panels::{Panel, draw_arrows, draw_flow, draw_heat};
use super::strongest::Strongest;
use super::text::{Anchor, Style};
use super::ticks::number;
use super::time_plot;

/// Width of the picture, px.
pub(super) const WIDTH: f32 = 1600.0;
pub(super) const MARGIN: f32 = 40.0;
/// Between panels, px.
pub(super) const GAP: f32 = 40.0;
/// Width of a panel and its legend, px.
pub(super) const COLUMN: f32 = (WIDTH - 2.0 * MARGIN - 2.0 * GAP) / 3.0;
/// A tall image is scaled to fit its column, px.
pub(super) const MAX_PANEL_HEIGHT: f32 = 600.0;
pub(super) const PANEL_TOP: f32 = 152.0;
pub(super) const LEGEND_HEIGHT: f32 = 124.0;
const TIME_PLOT_HEIGHT: f32 = 216.0;

pub(super) const BACKGROUND: Rgb = [255; 3];
const INK: Rgb = [32, 33, 36];
const FAINT_INK: Rgb = [95, 99, 104];
pub(super) const WARNING_INK: Rgb = [179, 38, 30];

pub(super) const TITLE: Style = Style { size: 28.0, is_bold: true, colour: INK, anchor: Anchor::Left };
pub(super) const HEADING: Style = Style { size: 18.0, ..TITLE };
pub(super) const BODY: Style = Style { size: 16.0, is_bold: false, colour: INK, anchor: Anchor::Left };
pub(super) const NOTE: Style = Style { colour: FAINT_INK, ..BODY };

/// The picture of one frame of a run.
pub(super) fn draw(strongest: &Strongest, course: &Course, mm_per_px: Option<f32>) -> Image<Rgb> {
    let (columns, rows) = strongest.flow.size();
    let scale = (COLUMN / columns as f32).min(MAX_PANEL_HEIGHT / rows as f32);
    let (width, height) = ((scale * columns as f32).round().max(1.0), (scale * rows as f32).round().max(1.0));
    let legend_top = PANEL_TOP + height + 20.0;
    let time_plot_top = legend_top + LEGEND_HEIGHT + 28.0;
    let mut canvas = Canvas::new(WIDTH as u32, (time_plot_top + TIME_PLOT_HEIGHT + 24.0) as u32, BACKGROUND);

    draw_title(&mut canvas, strongest, course);
    let panel = |place: f32| Panel {
        image: Area { x: MARGIN + place * (COLUMN + GAP), y: PANEL_TOP, width, height },
        legend: Area { x: MARGIN + place * (COLUMN + GAP), y: legend_top, width: COLUMN, height: LEGEND_HEIGHT },
        scale,
    };
    draw_arrows(&mut canvas, panel(0.0), strongest, mm_per_px);
    draw_flow(&mut canvas, panel(1.0), strongest);
    draw_heat(&mut canvas, panel(2.0), strongest);
    let area = Area { x: MARGIN, y: time_plot_top, width: WIDTH - 2.0 * MARGIN, height: TIME_PLOT_HEIGHT };
    time_plot::draw(&mut canvas, area, course, Some(strongest.frame));
    canvas.into_image()
}

fn draw_title(canvas: &mut Canvas, strongest: &Strongest, course: &Course) {
    let time_s = strongest.capture_time_s - course.start_s();
    let strength = strongest.strength;
    let title = if strength.max_px.is_nan() {
        format!("Frame {}: no valid flow", strongest.sequence)
    } else {
        format!("Frame {} at {time_s:.2} s: flow up to {} px", strongest.sequence, number(strength.max_px))
    };
    canvas.text(&title, (MARGIN, 60.0), TITLE);

    let frames = course.frames();
    let mut facts = vec![if strength.mean_px.is_nan() {
        format!("No frame of {frames} holds valid flow")
    } else {
        format!("Strongest of {frames} frames: mean flow {} px", number(strength.mean_px))
    }];
    facts.extend(strongest.max_depth_mm.map(|depth| format!("depth up to {} mm", number(depth))));
    facts.extend(strongest.contact_area_mm2.map(|area| format!("contact {} mm²", number(area))));
    facts.extend(strongest.force_n.map(|force| {
        let [x, y, z] = force.map(number);
        format!("force ({x}, {y}, {z}) N")
    }));
    facts.extend(strongest.torque_nmm.map(|torque| format!("torque {} N mm", number(torque))));
    canvas.text(&facts.join("  ·  "), (MARGIN, 90.0), NOTE);
    if strongest.flags.iter().next().is_some() {
        let style = Style { is_bold: true, colour: WARNING_INK, anchor: Anchor::Right, ..BODY };
        canvas.text(&format!("Flags: {}", strongest.flags), (WIDTH - MARGIN, 60.0), style);
    }
}

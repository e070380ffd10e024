//! Lays out the preview: title, three panels with their legends, the plots over time.

use fingervision_image::Image;
use fingervision_plot::page::{
    BACKGROUND, BODY, COLUMN, GAP, LEGEND_HEIGHT, MARGIN, MAX_PANEL_HEIGHT, NOTE, PANEL_TOP, TITLE, WARNING_INK, WIDTH,
};
use fingervision_plot::{Anchor, Area, Canvas, Panel, Rgb, Style, number};

use super::course::Course;
use super::panels::{draw_arrows, draw_flow, draw_heat};
use super::strongest::Strongest;

const TIME_PLOT_HEIGHT: f32 = 216.0;

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
    course.plots().draw(&mut canvas, area, Some(strongest.frame));
    canvas.into_image()
}

fn draw_title(canvas: &mut Canvas, strongest: &Strongest, course: &Course) {
    let time_s = strongest.numbers.capture_time_s - course.start_s();
    let strength = strongest.strength;
    let title = if strength.max_px.is_nan() {
        format!("Frame {}: no valid flow", strongest.numbers.sequence)
    } else {
        format!("Frame {} at {time_s:.2} s: flow up to {} px", strongest.numbers.sequence, number(strength.max_px))
    };
    canvas.text(&title, (MARGIN, 60.0), TITLE);

    let frames = course.frames();
    let mut facts = vec![if strength.mean_px.is_nan() {
        format!("No frame of {frames} holds valid flow")
    } else {
        let of = if frames == 1 { "The only frame".into() } else { format!("Strongest of {frames} frames") };
        format!("{of}: mean flow {} px", number(strength.mean_px))
    }];
    facts.extend(strongest.numbers.max_depth_mm.map(|depth| format!("depth up to {} mm", number(depth))));
    facts.extend(strongest.numbers.contact_area_mm2.map(|area| format!("contact {} mm²", number(area))));
    facts.extend(strongest.numbers.force_n.map(|force| {
        let [x, y, z] = force.map(number);
        format!("force ({x}, {y}, {z}) N")
    }));
    facts.extend(strongest.numbers.torque_nmm.map(|torque| format!("torque {} N mm", number(torque))));
    canvas.text(&facts.join("  ·  "), (MARGIN, 90.0), NOTE);
    if strongest.numbers.flags.iter().next().is_some() {
        let style = Style { is_bold: true, colour: WARNING_INK, anchor: Anchor::Right, ..BODY };
        canvas.text(&format!("Flags: {}", strongest.numbers.flags), (WIDTH - MARGIN, 60.0), style);
    }
}

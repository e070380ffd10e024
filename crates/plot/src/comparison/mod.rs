//! Estimated fields beside the true ones: truth, estimate and difference side by side, errors over frames below.

mod maps;

use fingervision_flow::FlowField;
use fingervision_image::Image;

use crate::canvas::{Area, Canvas};
use crate::colour::Rgb;
use crate::lines::FramePlot;
use crate::outline::Outline;
use crate::page::{BACKGROUND, COLUMN, GAP, LEGEND_HEIGHT, MARGIN, MAX_PANEL_HEIGHT, NOTE, PANEL_TOP, TITLE, WIDTH};
use crate::panel::Panel;
use maps::Row;

/// Distance between the legends of a row and the panels of the next, px: for headings.
const ROW_GAP: f32 = 56.0;
/// Below the last legends, px.
const PLOT_GAP: f32 = 28.0;
const PLOT_HEIGHT: f32 = 300.0;

/// A true field and its estimate, both on the same grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair<'a, T> {
    /// The true field.
    pub truth: &'a T,
    /// The estimated field.
    pub estimate: &'a T,
}

/// One frame's fields, true and estimated, and the errors over all frames.
///
/// A row for depth and one for the flow, if they exist, 1600 px wide: truth and estimate on one scale, then estimate −
/// truth on its own scale. Grey means not compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison<'a> {
    /// The first line.
    pub title: &'a str,
    /// The line below.
    pub facts: &'a str,
    /// Depth, mm, positive pressed in.
    pub depth_mm: Option<Pair<'a, Image<f32>>>,
    /// Displacement, px.
    pub flow_px: Option<Pair<'a, FlowField>>,
    /// 1 where the truth is valid, 0 elsewhere; the size of all fields.
    pub seen: &'a Image<u8>,
    /// 1 where the estimate is valid, 0 elsewhere.
    pub valid: &'a Image<u8>,
    /// 1 where the estimated depth is valid: the same mask, unless depth has its own.
    pub depth_valid: &'a Image<u8>,
    /// 1 where the gel is touched; its border is drawn.
    pub contact: Option<&'a Image<u8>>,
    /// The frame's place in the lines of the plots.
    pub shown_frame: usize,
    /// The plots below, side by side.
    pub plots: &'a [FramePlot],
}

impl Comparison<'_> {
    /// The picture.
    ///
    /// # Panics
    ///
    /// If the fields differ in size.
    #[must_use]
    pub fn draw(&self) -> Image<Rgb> {
        let (columns, rows) = self.seen.size();
        let scale = (COLUMN / columns as f32).min(MAX_PANEL_HEIGHT / rows as f32);
        let (width, height) = ((scale * columns as f32).round().max(1.0), (scale * rows as f32).round().max(1.0));
        let row_height = height + 20.0 + LEGEND_HEIGHT;
        let count = usize::from(self.depth_mm.is_some()) + usize::from(self.flow_px.is_some());
        let plot_top = PANEL_TOP + count as f32 * (row_height + ROW_GAP) - ROW_GAP + PLOT_GAP;
        let mut canvas = Canvas::new(WIDTH as u32, (plot_top + PLOT_HEIGHT + 24.0) as u32, BACKGROUND);
        canvas.text(self.title, (MARGIN, 60.0), TITLE);
        canvas.text(self.facts, (MARGIN, 90.0), NOTE);

        let outline = self.contact.map(Outline::of);
        let row = |number: f32, valid| {
            let top = PANEL_TOP + number * (row_height + ROW_GAP);
            let panels = [0.0, 1.0, 2.0].map(|place| {
                let x = MARGIN + place * (COLUMN + GAP);
                let image = Area { x, y: top, width, height };
                let legend = Area { x, y: top + height + 20.0, width: COLUMN, height: LEGEND_HEIGHT };
                Panel { image, legend, scale }
            });
            Row { panels, seen: self.seen, valid, outline: outline.as_ref() }
        };
        let mut number = 0.0;
        if let Some(pair) = &self.depth_mm {
            row(number, self.depth_valid).draw_depth(&mut canvas, pair);
            number += 1.0;
        }
        if let Some(pair) = &self.flow_px {
            row(number, self.valid).draw_flow(&mut canvas, pair);
        }
        self.draw_plots(&mut canvas, plot_top);
        canvas.into_image()
    }

    fn draw_plots(&self, canvas: &mut Canvas, y: f32) {
        let count = self.plots.len().max(1) as f32;
        let width = (WIDTH - 2.0 * MARGIN - (count - 1.0) * GAP) / count;
        let mut x = MARGIN;
        for plot in self.plots {
            plot.draw(canvas, Area { x, y, width, height: PLOT_HEIGHT }, self.shown_frame);
            x += width + GAP;
        }
    }
}

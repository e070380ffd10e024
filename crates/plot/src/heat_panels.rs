//! Fields of one number in rows, each with its colour bar.

use fingervision_image::Image;

use crate::canvas::{Area, Canvas};
use crate::colour::Rgb;
use crate::heat_map::{HeatScale, heat_map};
use crate::keys::{draw_colour_bar, draw_invalid_key};
use crate::page::{BACKGROUND, COLUMN, GAP, LEGEND_HEIGHT, MARGIN, MAX_PANEL_HEIGHT, NOTE, PANEL_TOP, TITLE, WIDTH};
use crate::panel::Panel;

/// Distance between the legends of a row and the panels of the next, px: for headings.
const ROW_GAP: f32 = 56.0;

/// A field with its scale.
#[derive(Debug, Clone, PartialEq)]
pub struct HeatPanel<'a> {
    /// The name, with its unit.
    pub heading: String,
    /// The field; values that are not a number are shown as not valid.
    pub values: &'a Image<f32>,
    /// Its colours.
    pub scale: HeatScale,
    /// A line of explanation.
    pub note: String,
}

/// Rows of up to three fields on one page of 1600 px. All fields cover the same part of the camera image.
#[derive(Debug, Clone, PartialEq)]
pub struct HeatPanels<'a> {
    /// The first line.
    pub title: &'a str,
    /// The line below.
    pub facts: &'a str,
    /// Columns and rows of the part that the fields cover, px: the panels' shape, whatever the fields' resolution.
    pub size: (usize, usize),
    /// The rows.
    pub rows: Vec<Vec<HeatPanel<'a>>>,
}

impl HeatPanels<'_> {
    /// The picture.
    #[must_use]
    pub fn draw(&self) -> Image<Rgb> {
        let (columns, rows) = (self.size.0 as f32, self.size.1 as f32);
        let scale = (COLUMN / columns).min(MAX_PANEL_HEIGHT / rows);
        let (width, height) = ((scale * columns).round().max(1.0), (scale * rows).round().max(1.0));
        let row_height = height + 20.0 + LEGEND_HEIGHT + ROW_GAP;
        let bottom = PANEL_TOP + self.rows.len() as f32 * row_height - ROW_GAP;
        let mut canvas = Canvas::new(WIDTH as u32, bottom as u32, BACKGROUND);
        canvas.text(self.title, (MARGIN, 60.0), TITLE);
        canvas.text(self.facts, (MARGIN, 90.0), NOTE);
        let mut y = PANEL_TOP;
        for row in &self.rows {
            let mut x = MARGIN;
            for shown in row {
                let legend = Area { x, y: y + height + 20.0, width: COLUMN, height: LEGEND_HEIGHT };
                shown.draw(&mut canvas, Panel { image: Area { x, y, width, height }, legend, scale });
                x += COLUMN + GAP;
            }
            y += row_height;
        }
        canvas.into_image()
    }
}

impl HeatPanel<'_> {
    fn draw(&self, canvas: &mut Canvas, panel: Panel) {
        let (columns, rows) = self.values.size();
        let valid = Image::from_fn(columns, rows, |x, y| u8::from(self.values.at(x, y).is_finite()));
        panel.put(canvas, &self.heading, &panel.fit(&heat_map(self.values, &valid, self.scale)));
        draw_colour_bar(canvas, Area { height: 16.0, ..panel.legend }, self.scale);
        canvas.text(&self.note, (panel.legend.x, panel.line(2.2)), NOTE);
        if valid.values().contains(&0) {
            draw_invalid_key(canvas, (panel.legend.x, panel.line(3.4)), "not valid");
        }
    }
}

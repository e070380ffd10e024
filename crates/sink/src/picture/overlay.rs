//! A video of a run: the camera image with the contact, depth, and force over time.

use std::path::Path;

use fingervision_image::{Frame, Image, Rect};
use fingervision_plot::page::{BACKGROUND, BODY, GAP, HEADING, MARGIN, WARNING_INK};
use fingervision_plot::{Anchor, Area, Canvas, Outline, Panel, Rgb, Style, number};
use fingervision_touch::{Flag, Reading};

use super::course::Course;
use super::panels::draw_heat_up_to;
use super::preview::PreviewOptions;
use super::strongest::{Strength, Strongest};
use crate::video::Video;
use crate::{Sink, SinkError};

/// Largest size of a panel, px; small fields are enlarged, up to this factor.
const MAX_WIDTH: f32 = 640.0;
const MAX_HEIGHT: f32 = 480.0;
const MAX_SCALE: f32 = 3.0;
/// With a smaller width, the text below would not fit, px.
const LEAST_WIDTH: f32 = 420.0;
const TOP: f32 = 92.0;
const LEGEND_HEIGHT: f32 = 104.0;
const PLOT_HEIGHT: f32 = 216.0;

/// Draws every reading and appends it to a video, in constant memory.
///
/// Left, the camera image with the outline of the contact at the current positions of its points; right, depth, or what
/// [`Preview`](super::Preview) shows instead, at the positions at rest. The colours end at a round number that only
/// grows. Below, flow, depth and force up to this frame.
///
/// The ending of the file's name says what the video is. `.mp4`, with the feature `mp4`: H.264, whose pictures have their own
/// times. Otherwise: motion JPEG in AVI, whose pictures are all shown for the same time, the mean between them.
#[derive(Debug)]
pub struct Overlay {
    to: Video,
    region: Option<Rect>,
    course: Course,
    shown: Strongest,
    colour: Image<Rgb>,
    layout: Layout,
    limit: f32,
}

/// The layout of a frame.
#[derive(Debug, Clone, Copy)]
struct Layout {
    columns: usize,
    rows: usize,
    /// Px on the video per px of the fields.
    scale: f32,
    width: f32,
    height: f32,
}

impl Overlay {
    /// Creates the video for fields of this size, px.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the file cannot be written, [`SinkError::NotBuilt`] for MP4 without the feature.
    pub fn create(path: &Path, size: (usize, usize), options: PreviewOptions) -> Result<Self, SinkError> {
        let layout = Layout::of(size);
        let to = Video::create(path, (layout.width as usize, layout.height as usize))?;
        Ok(Self {
            to,
            region: options.region,
            course: Course::new(),
            shown: Strongest::none(),
            colour: Image::filled(0, 0, [0; 3]),
            layout,
            limit: 0.0,
        })
    }

    /// Closes the video and flushes it to the disk.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the disk refuses it.
    pub fn finish(self) -> Result<(), SinkError> {
        self.to.finish()
    }

    fn draw(&mut self) -> Image<Rgb> {
        let Layout { width, height, .. } = self.layout;
        let mut canvas = Canvas::new(width as u32, height as u32, BACKGROUND);
        self.draw_title(&mut canvas);
        let camera = self.layout.panel(0);
        self.draw_camera(&mut canvas, camera);
        self.limit = self.limit.max(self.shown.colour_end());
        draw_heat_up_to(&mut canvas, self.layout.panel(1), &self.shown, self.limit);
        let top = camera.legend.bottom() + 12.0;
        let plots = Area { x: MARGIN, y: top, width: width - 2.0 * MARGIN, height: PLOT_HEIGHT };
        self.course.plots().draw(&mut canvas, plots, None);
        canvas.into_image()
    }

    fn draw_title(&self, canvas: &mut Canvas) {
        let shown = &self.shown;
        let time_s = shown.numbers.capture_time_s - self.course.start_s();
        canvas.text(&format!("Frame {} at {time_s:.2} s", shown.numbers.sequence), (MARGIN, 40.0), HEADING);
        if shown.numbers.flags.iter().next().is_some() {
            let style = Style { colour: WARNING_INK, anchor: Anchor::Right, ..BODY };
            canvas.text(&format!("{}", shown.numbers.flags), (self.layout.width - MARGIN, 40.0), style);
        }
    }

    /// The camera image, the contact on it, and the numbers below.
    fn draw_camera(&self, canvas: &mut Canvas, panel: Panel) {
        panel.put(canvas, "Camera image", &panel.fit(&self.colour));
        let shown = &self.shown;
        if let Some(contact) = &shown.contact {
            let (width, height) = shown.flow.size();
            let flow = |(x, y): (f32, f32)| {
                let (x, y) = ((x as usize).min(width - 1), (y as usize).min(height - 1));
                let (u, v) = (shown.flow.u.at(x, y), shown.flow.v.at(x, y));
                if u.is_finite() && v.is_finite() { (u, v) } else { (0.0, 0.0) }
            };
            Outline::of(contact).moved(flow).draw(canvas, panel);
        }
        let mut facts = Vec::new();
        facts.extend(shown.numbers.max_depth_mm.map(|depth| format!("depth up to {} mm", number(depth))));
        facts.extend(shown.numbers.contact_area_mm2.map(|area| format!("contact {} mm²", number(area))));
        facts.extend(
            shown.numbers.force_n.map(|[x, y, normal]| {
                format!("normal force {} N, shear force {} N", number(normal), number(x.hypot(y)))
            }),
        );
        if facts.is_empty() {
            facts.push(format!("mean flow {} px", number(shown.strength.mean_px)));
        }
        for (line, fact) in facts.iter().enumerate() {
            canvas.text(fact, (panel.legend.x, panel.line(line as f32)), BODY);
        }
    }
}

impl Sink for Overlay {
    /// Draws a reading onto its frame and appends it.
    ///
    /// # Errors
    ///
    /// [`SinkError::SizeMismatch`] if the fields do not cover the frame's region of interest, [`SinkError::Write`] if the
    /// file cannot take the picture.
    fn write(&mut self, reading: &Reading, frame: &Frame) -> Result<(), SinkError> {
        let (width, height) = frame.pixels.size();
        let region = self.region.unwrap_or(Rect::whole(width, height));
        self.shown.copy_from(reading, frame, region)?;
        self.shown.strength = Strength::of(reading);
        if reading.flags.has(Flag::Lost) {
            self.shown.contact = None;
        }
        self.course.push(reading, self.shown.strength.mean_px);
        self.colour = Image::from_fn(region.width, region.height, |x, y| {
            frame.pixels.levels(region.x + x, region.y + y).map(|level| level.clamp(0.0, 255.0) as u8)
        });
        let picture = self.draw();
        let spans = self.course.frames().saturating_sub(1).max(1) as f64;
        let time_s = reading.capture_time_s - self.course.start_s();
        self.to.write(&picture, time_s, time_s / spans)
    }
}

impl Layout {
    fn of((columns, rows): (usize, usize)) -> Self {
        let scale = (MAX_WIDTH / columns as f32).min(MAX_HEIGHT / rows as f32).min(MAX_SCALE);
        let layout = Self { columns, rows, scale, width: 0.0, height: 0.0 };
        let panel = layout.panel(1);
        // Encoders of other codecs need even sides.
        let even = |side: f32| 2.0 * (side / 2.0).ceil();
        let width = even(panel.legend.right() + MARGIN);
        Self { width, height: even(panel.legend.bottom() + 12.0 + PLOT_HEIGHT + 8.0), ..layout }
    }

    /// The left panel is 0, the right one is 1.
    fn panel(self, place: u8) -> Panel {
        let side = |count: usize| (self.scale * count as f32).round().max(1.0);
        let (width, height) = (side(self.columns), side(self.rows));
        let column = width.max(LEAST_WIDTH);
        let x = MARGIN + f32::from(place) * (column + GAP);
        Panel {
            image: Area { x, y: TOP, width, height },
            legend: Area { x, y: TOP + height + 20.0, width: column, height: LEGEND_HEIGHT },
            scale: self.scale,
        }
    }
}

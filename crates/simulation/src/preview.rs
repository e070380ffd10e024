//! The picture of a simulated press: the camera image at the largest depth, its truth, and the forces.

use std::path::Path;

use fingervision_flow::FlowField;
use fingervision_gel::{Scene, Truth};
use fingervision_image::{Image, Pixels};
use fingervision_plot::page::{
    BACKGROUND, COLUMN, GAP, HEADING, LEGEND_HEIGHT, MARGIN, MAX_PANEL_HEIGHT, NOTE, PANEL_TOP, TITLE, WIDTH,
};
use fingervision_plot::{
    Area, Canvas, FramePlot, HeatScale, LEAST_FLOW_PX, Outline, Panel, Rgb, draw_colour_bar, draw_invalid_key,
    draw_outline_key, draw_wheel_key, flow_colours, heat_map, number, resized, round_up,
};
use fingervision_sink::{SinkError, write_png};

use crate::frame::SimulatedFrame;

/// Number of frames in the strip below the panels, and the distance between them, px.
const STRIP: usize = 8;
const STRIP_GAP: f32 = 16.0;
const STRIP_WIDTH: f32 = (WIDTH - 2.0 * MARGIN - (STRIP - 1) as f32 * STRIP_GAP) / STRIP as f32;
const PLOT_HEIGHT: f32 = 280.0;
/// Least end of the colour scale of depth, mm: rounding must not look like touch.
const LEAST_DEPTH_MM: f32 = 0.01;

/// Stores what the picture of a simulated press shows, in constant memory except for a few numbers per frame.
#[derive(Debug)]
pub struct SimulationPreview {
    title: String,
    about: String,
    frames: usize,
    shown: Option<Shown>,
    strip: Vec<Image<Rgb>>,
    normal_n: Vec<f32>,
    shear_n: Vec<f32>,
}

/// The frame that is shown large.
#[derive(Debug)]
struct Shown {
    frame: usize,
    depth_mm: f64,
    force_n: [f64; 3],
    image: Option<Image<Rgb>>,
    truth: Truth,
}

impl SimulationPreview {
    /// A preview for a scene with this number of frames.
    #[must_use]
    pub fn new(scene: &Scene, frames: usize) -> Self {
        Self {
            title: scene.name.clone(),
            about: scene.about.clone(),
            frames,
            shown: None,
            strip: Vec::new(),
            normal_n: Vec::with_capacity(frames),
            shear_n: Vec::with_capacity(frames),
        }
    }

    /// Takes the next frame; the last of the deepest is shown.
    pub fn write(&mut self, frame: &SimulatedFrame) {
        let count = self.normal_n.len();
        let [x, y, z] = frame.force_n;
        self.normal_n.push(z.max(0.0) as f32);
        self.shear_n.push(x.hypot(y) as f32);
        if let Some(pixels) = frame.pixels.filter(|_| self.is_in_strip(count)) {
            let (width, height) = pixels.size();
            let scale = STRIP_WIDTH / width as f32;
            let height = (height as f32 * scale).round().max(1.0) as usize;
            self.strip.push(resized(&colours(pixels), STRIP_WIDTH as usize, height));
        }
        if self.shown.as_ref().is_none_or(|shown| frame.depth_mm >= shown.depth_mm) {
            let (depth_mm, force_n) = (frame.depth_mm, frame.force_n);
            let (image, truth) = (frame.pixels.map(colours), frame.truth.clone());
            self.shown = Some(Shown { frame: count, depth_mm, force_n, image, truth });
        }
    }

    /// Whether a frame is one of those, spread evenly over all, that the strip shows.
    fn is_in_strip(&self, frame: usize) -> bool {
        let (last, steps) = (self.frames.max(2) - 1, STRIP - 1);
        (0..STRIP).any(|place| (place * last + steps / 2) / steps == frame)
    }

    /// Writes the picture as PNG.
    ///
    /// # Errors
    ///
    /// [`SinkError::NoReadings`] if nothing was seen, [`SinkError::Write`] if the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), SinkError> {
        write_png(&self.draw()?, path)
    }

    /// The picture of the frames so far.
    ///
    /// # Errors
    ///
    /// [`SinkError::NoReadings`] if nothing was.
    pub fn draw(&self) -> Result<Image<Rgb>, SinkError> {
        let shown = self.shown.as_ref().ok_or(SinkError::NoReadings)?;
        let (columns, rows) = shown.truth.depth.size();
        let scale = (COLUMN / columns as f32).min(MAX_PANEL_HEIGHT / rows as f32);
        let (width, height) = ((scale * columns as f32).round().max(1.0), (scale * rows as f32).round().max(1.0));
        let strip_top = PANEL_TOP + height + 20.0 + LEGEND_HEIGHT + 28.0;
        let strip_height = self.strip.first().map_or(0.0, |image| image.height() as f32 + 60.0);
        let plot_top = strip_top + strip_height;
        let has_force = self.normal_n.iter().chain(&self.shear_n).any(|&force| force > 0.0);
        let bottom = if has_force { plot_top + PLOT_HEIGHT } else { plot_top };
        let mut canvas = Canvas::new(WIDTH as u32, (bottom + 24.0) as u32, BACKGROUND);
        canvas.text(&self.title, (MARGIN, 60.0), TITLE);
        canvas.text(&self.facts(shown), (MARGIN, 90.0), NOTE);
        let panels = [0.0, 1.0, 2.0].map(|place| {
            let (x, y) = (MARGIN + place * (COLUMN + GAP), PANEL_TOP);
            let legend = Area { x, y: y + height + 20.0, width: COLUMN, height: LEGEND_HEIGHT };
            Panel { image: Area { x, y, width, height }, legend, scale }
        });
        shown.draw(&mut canvas, panels);
        if !self.strip.is_empty() {
            canvas.text("From the first frame to the last", (MARGIN, strip_top), HEADING);
        }
        for (place, image) in self.strip.iter().enumerate() {
            canvas.copy(image, (MARGIN + place as f32 * (STRIP_WIDTH + STRIP_GAP)) as usize, strip_top as usize + 14);
        }
        if has_force {
            let area = Area { x: MARGIN, y: plot_top, width: WIDTH - 2.0 * MARGIN, height: PLOT_HEIGHT };
            self.forces().draw(&mut canvas, area, shown.frame);
        }
        Ok(canvas.into_image())
    }

    fn facts(&self, shown: &Shown) -> String {
        let [x, y, z] = shown.force_n.map(|force| number(force as f32));
        let (frame, last, depth) = (shown.frame, self.normal_n.len().saturating_sub(1), number(shown.depth_mm as f32));
        let about = if self.about.is_empty() { String::new() } else { format!("{}  ·  ", self.about) };
        format!("{about}Frame {frame}, of 0 to {last}: {depth} mm deep, force on the gel ({x}, {y}, {z}) N")
    }

    fn forces(&self) -> FramePlot {
        let lines = [("normal", &self.normal_n), ("shear", &self.shear_n)];
        let lines = lines.map(|(name, values)| (name.to_owned(), values.clone())).to_vec();
        FramePlot { heading: "Force on the gel, N".into(), lines }
    }
}

impl Shown {
    fn draw(&self, canvas: &mut Canvas, [seen, depth, flow]: [Panel; 3]) {
        let truth = &self.truth;
        let outline = Outline::of(&truth.contact);
        match &self.image {
            Some(image) => seen.put(canvas, "Camera image", &seen.fit(image)),
            None => seen.put(canvas, "Contact", &seen.fit(&contact_map(&truth.contact))),
        }
        let everywhere = Image::filled(truth.depth.width(), truth.depth.height(), 1);
        let limit = round_up(largest(truth.depth.values().iter().copied()).max(LEAST_DEPTH_MM));
        let scale = HeatScale::around_zero(limit);
        depth.put(canvas, "Depth, mm", &depth.fit(&heat_map(&truth.depth, &everywhere, scale)));
        outline.draw(canvas, depth);
        draw_colour_bar(canvas, Area { height: 16.0, ..depth.legend }, scale);
        canvas.text("Red is pressed in, blue bulges out.", (depth.legend.x, depth.line(2.2)), NOTE);
        if truth.contact.values().contains(&1) {
            let y = depth.line(3.4);
            let x = draw_outline_key(canvas, (depth.legend.x, y));
            canvas.text("border of the contact", (x, y), NOTE);
        }

        let along = |axis: usize| {
            let at = |x: usize, y: usize| truth.flow.at(x, y)[axis];
            Image::from_fn(truth.flow.width(), truth.flow.height(), at)
        };
        let field = FlowField { u: along(0), v: along(1) };
        let longest = largest(truth.flow.values().iter().map(|[x, y]| x.hypot(*y)));
        let radius_px = round_up(longest.max(LEAST_FLOW_PX));
        flow.put(canvas, "Flow", &flow.fit(&flow_colours(&field, &truth.visible, radius_px)));
        let x = draw_wheel_key(canvas, flow, radius_px);
        draw_invalid_key(canvas, (x, flow.line(3.2)), "not visible");
    }
}

fn largest(values: impl Iterator<Item = f32>) -> f32 {
    values.filter(|value| value.is_finite()).fold(0.0, |largest, value| largest.max(value.abs()))
}

fn contact_map(contact: &Image<u8>) -> Image<Rgb> {
    let colour = |x, y| if contact.at(x, y) == 1 { [60; 3] } else { [240; 3] };
    Image::from_fn(contact.width(), contact.height(), colour)
}

/// The frame for display: 16 bits lose their lower eight, grey repeats.
fn colours(pixels: &Pixels) -> Image<Rgb> {
    let (width, height) = pixels.size();
    Image::from_fn(width, height, |x, y| pixels.levels(x, y).map(|level| level.round() as u8))
}

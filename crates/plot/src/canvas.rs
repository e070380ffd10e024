//! A picture to draw on: lines, filled shapes, text and other images, all anti-aliased.

use fingervision_image::Image;
use image::imageops::{FilterType, resize};
use image::{ImageBuffer, RgbImage};
use tiny_skia::{Color, FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, Transform};

use crate::colour::Rgb;
use crate::text::Style;

/// A place on the canvas, px from its upper left corner.
pub type Point = (f32, f32);

/// A rectangle on the canvas, px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    /// Its left side.
    pub x: f32,
    /// Its upper side.
    pub y: f32,
    /// From left to right.
    pub width: f32,
    /// From top to bottom.
    pub height: f32,
}

impl Area {
    /// Its right side, px.
    #[must_use]
    pub fn right(&self) -> f32 {
        self.x + self.width
    }

    /// Its lower side, px.
    #[must_use]
    pub fn bottom(&self) -> f32 {
        self.y + self.height
    }
}

/// The canvas.
#[derive(Debug)]
pub struct Canvas {
    pixels: Pixmap,
}

impl Canvas {
    /// A canvas of one colour.
    ///
    /// # Panics
    ///
    /// If a side is zero.
    #[must_use]
    pub fn new(width: u32, height: u32, background: Rgb) -> Self {
        let mut pixels = Pixmap::new(width, height).expect("a canvas has pixels");
        let [red, green, blue] = background;
        pixels.fill(Color::from_rgba8(red, green, blue, 255));
        Self { pixels }
    }

    /// A canvas that starts as an image.
    #[must_use]
    pub fn of(image: &Image<Rgb>) -> Self {
        let mut canvas = Self::new(image.width() as u32, image.height() as u32, [0; 3]);
        canvas.copy(image, 0, 0);
        canvas
    }

    /// A line through points, round at corners and ends.
    pub fn line(&mut self, points: &[Point], width: f32, colour: Rgb) {
        let stroke = Stroke { width, line_cap: LineCap::Round, line_join: LineJoin::Round, ..Stroke::default() };
        if let Some(path) = path_through(points, false) {
            self.pixels.stroke_path(&path, &paint(colour), &stroke, Transform::identity(), None);
        }
    }

    /// A filled polygon.
    pub fn polygon(&mut self, corners: &[Point], colour: Rgb) {
        if let Some(path) = path_through(corners, true) {
            self.fill(&path, colour);
        }
    }

    /// A filled rectangle.
    pub fn rectangle(&mut self, area: Area, colour: Rgb) {
        let corners =
            [(area.x, area.y), (area.right(), area.y), (area.right(), area.bottom()), (area.x, area.bottom())];
        self.polygon(&corners, colour);
    }

    /// A filled circle.
    pub fn disc(&mut self, (x, y): Point, radius: f32, colour: Rgb) {
        if let Some(path) = PathBuilder::from_circle(x, y, radius) {
            self.fill(&path, colour);
        }
    }

    /// A text with its anchor at a place on the baseline.
    pub fn text(&mut self, text: &str, (x, y): Point, style: Style) {
        if let Some(path) = style.outline(text, x, y) {
            self.fill(&path, style.colour);
        }
    }

    /// Puts an image's upper left corner at whole pixels; the part beyond the edge is left out.
    pub fn copy(&mut self, image: &Image<Rgb>, left: usize, top: usize) {
        let (width, height) = (self.pixels.width() as usize, self.pixels.height() as usize);
        let pixels = self.pixels.pixels_mut();
        let columns = image.width().min(width.saturating_sub(left));
        for (y, row) in (top..height).zip(image.rows()) {
            let to = &mut pixels[y * width + left..][..columns];
            for (to, &[red, green, blue]) in to.iter_mut().zip(row) {
                *to = tiny_skia::ColorU8::from_rgba(red, green, blue, 255).premultiply();
            }
        }
    }

    /// The picture drawn so far.
    #[must_use]
    pub fn into_image(self) -> Image<Rgb> {
        let (width, pixels) = (self.pixels.width() as usize, self.pixels.pixels());
        let at = |x, y| {
            let pixel: tiny_skia::PremultipliedColorU8 = pixels[y * width + x];
            [pixel.red(), pixel.green(), pixel.blue()]
        };
        Image::from_fn(width, self.pixels.height() as usize, at)
    }

    fn fill(&mut self, path: &Path, colour: Rgb) {
        self.pixels.fill_path(path, &paint(colour), FillRule::Winding, Transform::identity(), None);
    }
}

/// An image at another size: a smaller pixel averages those that it covers, a larger image is interpolated.
#[must_use]
pub fn resized(image: &Image<Rgb>, width: usize, height: usize) -> Image<Rgb> {
    if image.size() == (width, height) {
        return image.clone();
    }
    let resized = resize(&as_buffer(image), width as u32, height as u32, FilterType::Triangle);
    Image::from_fn(width, height, |x, y| resized.get_pixel(x as u32, y as u32).0)
}

/// The image as the type of the library that scales.
fn as_buffer(image: &Image<Rgb>) -> RgbImage {
    let levels = image.values().iter().flatten().copied().collect();
    ImageBuffer::from_raw(image.width() as u32, image.height() as u32, levels).expect("three levels a pixel")
}

fn paint(colour: Rgb) -> Paint<'static> {
    let [red, green, blue] = colour;
    let mut paint = Paint::default();
    paint.set_color_rgba8(red, green, blue, 255);
    paint
}

fn path_through(points: &[Point], is_closed: bool) -> Option<Path> {
    let (&(x, y), rest) = points.split_first()?;
    let mut path = PathBuilder::new();
    path.move_to(x, y);
    for &(x, y) in rest {
        path.line_to(x, y);
    }
    if is_closed {
        path.close();
    }
    path.finish()
}

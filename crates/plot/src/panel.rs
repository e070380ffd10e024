//! A panel of a page: an image with its heading above and its legend below.

use fingervision_image::Image;

use crate::canvas::{Area, Canvas, resized};
use crate::colour::Rgb;
use crate::page::HEADING;

const FRAME: Rgb = [200; 3];
/// From one line of text to the next, px.
const LINE: f32 = 24.0;

/// The position of a panel.
#[derive(Debug, Clone, Copy)]
pub struct Panel {
    /// Where its image lies.
    pub image: Area,
    /// Where its legend lies.
    pub legend: Area,
    /// Px on the picture per px of the field.
    pub scale: f32,
}

impl Panel {
    /// Draws an image of the panel's size, a thin frame around it and the heading above.
    pub fn put(self, canvas: &mut Canvas, heading: &str, image: &Image<Rgb>) {
        canvas.text(heading, (self.image.x, self.image.y - 14.0), HEADING);
        let Area { x, y, width, height } = self.image;
        // A thin frame: a field without motion is as white as the page.
        canvas.rectangle(Area { x: x - 1.0, y: y - 1.0, width: width + 2.0, height: height + 2.0 }, FRAME);
        canvas.copy(image, x as usize, y as usize);
    }

    /// The image at the panel's size.
    #[must_use]
    pub fn fit(self, image: &Image<Rgb>) -> Image<Rgb> {
        resized(image, self.image.width as usize, self.image.height as usize)
    }

    /// The baseline of a line of text in the legend, counted from 0.
    #[must_use]
    pub fn line(self, number: f32) -> f32 {
        self.legend.y + 16.0 + LINE * number
    }
}

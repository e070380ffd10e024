//! Small maps for galleries.

use fingervision_image::Image;
use fingervision_plot::{HeatScale, heat_map};

type Rgb = [u8; 3];

/// A map at half size, the size in a gallery.
pub(super) fn map(values: &Image<f32>, mask: &Image<u8>, scale: HeatScale) -> Image<Rgb> {
    halved(&heat_map(values, mask, scale))
}

/// Every second pixel of every second row.
pub(super) fn halved(image: &Image<Rgb>) -> Image<Rgb> {
    Image::from_fn(image.width().div_ceil(2), image.height().div_ceil(2), |x, y| image.at(2 * x, 2 * y))
}

/// The colours of a scale from its lower end to its upper one.
pub(super) fn bar(scale: HeatScale) -> Image<Rgb> {
    const WIDTH: usize = 240;
    let value = |x: usize| scale.low + (scale.high - scale.low) * x as f32 / (WIDTH - 1) as f32;
    Image::from_fn(WIDTH, 14, |x, _| scale.colour(value(x)))
}

/// The description of a colour bar.
pub(super) fn bar_caption(scale: HeatScale, unit: &str) -> String {
    format!("{} to {} {unit}", scale.low, scale.high).replace('-', "−")
}

pub(super) fn difference(a: &Image<f32>, b: &Image<f32>) -> Image<f32> {
    Image::from_fn(a.width(), a.height(), |x, y| a.at(x, y) - b.at(x, y))
}

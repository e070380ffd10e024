//! Pictures of runs, simulations and comparisons.

mod course;
mod overlay;
mod page;
mod panels;
mod preview;
mod strongest;

use std::path::Path;

use fingervision_image::{Image, Pixels};
use fingervision_plot::Rgb;
use image::codecs::png::PngEncoder;
use image::{ColorType, ImageEncoder};

pub use overlay::Overlay;
pub use preview::{Preview, PreviewOptions};

use crate::SinkError;
use crate::whole_file::write_file;

/// Writes an image as PNG.
///
/// # Errors
///
/// [`SinkError::Write`] if the file cannot be written.
pub fn write_png(image: &Image<Rgb>, path: &Path) -> Result<(), SinkError> {
    encode(image.values().as_flattened(), image.size(), ColorType::Rgb8, path)
}

/// An image as a PNG file's bytes.
///
/// # Errors
///
/// [`SinkError::Write`] if it cannot be encoded.
pub fn png(image: &Image<Rgb>) -> Result<Vec<u8>, SinkError> {
    encoded(image.values().as_flattened(), image.size(), ColorType::Rgb8)
        .map_err(SinkError::writing(Path::new("a picture")))
}

/// Writes a frame's pixels as PNG without changing their values: a folder of them is a recording.
///
/// # Errors
///
/// [`SinkError::Write`] if the file cannot be written.
pub fn write_pixels(pixels: &Pixels, path: &Path) -> Result<(), SinkError> {
    let size = pixels.size();
    match pixels {
        Pixels::Grey8(image) => encode(image.values(), size, ColorType::L8, path),
        Pixels::Rgb8(image) => encode(image.values().as_flattened(), size, ColorType::Rgb8, path),
        Pixels::Grey16(image) => encode(&bytes(image.values()), size, ColorType::L16, path),
        Pixels::Rgb16(image) => encode(&bytes(image.values().as_flattened()), size, ColorType::Rgb16, path),
    }
}

/// The library expects 16 bits in the machine's byte order.
fn bytes(levels: &[u16]) -> Vec<u8> {
    levels.iter().flat_map(|level| level.to_ne_bytes()).collect()
}

fn encode(bytes: &[u8], size: (usize, usize), kind: ColorType, path: &Path) -> Result<(), SinkError> {
    let file = encoded(bytes, size, kind).map_err(SinkError::writing(path))?;
    write_file(path, &file)
}

fn encoded(bytes: &[u8], (width, height): (usize, usize), kind: ColorType) -> std::io::Result<Vec<u8>> {
    let mut file = Vec::new();
    PngEncoder::new(&mut file)
        .write_image(bytes, width as u32, height as u32, kind.into())
        .map_err(std::io::Error::other)?;
    Ok(file)
}

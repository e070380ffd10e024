//! Pictures: people look before they read.

mod axes;
mod canvas;
mod colour_map;
mod comparison;
mod flow_colours;
mod heat_map;
mod lines;
mod outline;
mod page;
mod panels;
mod preview;
mod strongest;
mod text;
mod ticks;
mod time_plot;
mod trend;

use std::io::Cursor;
use std::path::Path;

use fingervision_image::Image;
use image::ImageFormat;

pub use colour_map::ColourMap;
pub use comparison::{Comparison, Pair};
pub use flow_colours::{colour_wheel, flow_colours};
pub use heat_map::{HeatScale, heat_map};
pub use lines::FramePlot;
pub use preview::{Preview, PreviewOptions};

use crate::SinkError;
use crate::claim::write_file;

/// Red, green and blue, 0 to 255.
type Rgb = [u8; 3];

/// Stands for "not valid" in every picture: a grey that no colour scale holds.
pub const INVALID_COLOUR: Rgb = [158; 3];

/// Writes an image as PNG.
///
/// # Errors
///
/// [`SinkError::Write`] if the file cannot be written.
pub fn write_png(image: &Image<Rgb>, path: &Path) -> Result<(), SinkError> {
    let mut bytes = Cursor::new(Vec::new());
    canvas::as_buffer(image)
        .write_to(&mut bytes, ImageFormat::Png)
        .map_err(std::io::Error::other)
        .map_err(SinkError::writing(path))?;
    write_file(path, bytes.get_ref())
}

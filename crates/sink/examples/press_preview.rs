//! Draws the preview of an artificial press to the given file.
//!
//! `cargo run -p fingervision-sink --example press_preview -- preview.png`

use std::path::Path;

use fingervision_image::Rect;
use fingervision_sink::{Preview, PreviewOptions, Sink};
use synthetic::Press;

#[path = "../tests/integration/synthetic.rs"]
mod synthetic;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).unwrap_or("preview.png".to_string());
    let press = Press { width: 610, height: 450, frames: 120 };
    let region = Rect { x: 15, y: 15, width: press.width, height: press.height };
    let mut preview = Preview::new(PreviewOptions { region: Some(region), mm_per_px: Some(0.049) });
    for frame in 0..press.frames {
        preview.write(&press.reading(frame), &press.frame(frame))?;
    }
    preview.save(Path::new(&path))?;
    Ok(())
}

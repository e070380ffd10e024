//! The last frame of an array of frames.

use std::path::Path;

use fingervision_image::Image;

use super::RunError;
use super::array::{FrameArray, Value};

/// The last frame of a `.npy` file with one value per pixel.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LastFrame {
    /// Its values; masks as 0 and 1.
    pub(crate) values: Image<f32>,
}

impl LastFrame {
    /// Reads it. `None` if the file does not exist.
    ///
    /// # Errors
    ///
    /// [`RunError`] if the file is not an array of frames of this size, or contains no frames.
    pub(crate) fn read<T: Value + Into<f32>>(
        path: &Path,
        (width, height): (usize, usize),
    ) -> Result<Option<Self>, RunError> {
        let Some(mut array) = FrameArray::<T>::open(path, 1)? else { return Ok(None) };
        let refused = |reason: String, hint: &str| RunError::Array { file: path.to_owned(), reason, hint: hint.into() };
        if array.size() != (width, height) {
            let (columns, rows) = array.size();
            let reason = format!("it has {columns}x{rows} px, the truth {width}x{height} px");
            return Err(refused(reason, "fields lie on the reference grid: the first image's pixels"));
        }
        if array.frames() == 0 {
            return Err(refused("it contains no frames".into(), "its last frame is evaluated"));
        }
        for _ in 0..array.frames() {
            array.advance()?;
        }
        let values = array.values();
        Ok(Some(Self { values: Image::from_fn(width, height, |x, y| values[y * width + x].into()) }))
    }

    /// The values as a mask.
    pub(crate) fn mask(&self) -> Image<u8> {
        let values = &self.values;
        Image::from_fn(values.width(), values.height(), |x, y| u8::from(values.at(x, y) != 0.0))
    }
}

//! Size and pixel format of a frame, to compare and to print.

use fingervision_image::Pixels;
use std::fmt;

/// The properties that must be the same for all frames of a source.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameFormat {
    /// Columns, px.
    pub width: usize,
    /// Rows, px.
    pub height: usize,
    /// Red, green and blue, or else grey.
    pub is_colour: bool,
    /// Bits of each channel: 8 or 16.
    pub bits: u8,
}

impl From<&Pixels> for FrameFormat {
    fn from(pixels: &Pixels) -> Self {
        let (width, height) = pixels.size();
        let bits = match pixels {
            Pixels::Grey8(_) | Pixels::Rgb8(_) => 8,
            Pixels::Grey16(_) | Pixels::Rgb16(_) => 16,
        };
        Self { width, height, is_colour: pixels.is_colour(), bits }
    }
}

impl fmt::Display for FrameFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = if self.is_colour { "colour" } else { "grey" };
        write!(f, "{}x{} px {}-bit {kind}", self.width, self.height, self.bits)
    }
}

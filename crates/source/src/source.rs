//! The interface of all sources.

use crate::SourceError;
use fingervision_image::{Frame, Pixels};
use serde::{Deserialize, Serialize};

/// A source of frames: a folder of images, a video file.
///
/// All frames of a source have one size and one pixel format. A source can be read on another thread than the one
/// that opened it.
pub trait Source: Send {
    /// The next frame, or `None` after the last.
    ///
    /// Frames are read one at a time and returned completely. After an error the source is at its end: the frames
    /// returned so far are valid, and every further call returns `None`, unless [`resume`](Self::resume) continues
    /// after it.
    ///
    /// # Errors
    ///
    /// [`SourceError::Frame`] and [`SourceError::PixelRange`] if the frame cannot be read,
    /// [`SourceError::FormatChanged`] if it differs from the first in size or pixel format, [`SourceError::NotFound`]
    /// and [`SourceError::Io`] if its file cannot be read.
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError>;

    /// Continues behind the frame for which [`next_frame`](Self::next_frame) returned an error; false if that is not
    /// possible.
    ///
    /// The next frame is the first one that does not depend on lost data: in H.264 the next key frame. Frames in
    /// between are left out; the sequence numbers have a gap.
    fn resume(&mut self) -> bool {
        false
    }

    /// Number of frames from the first to the last; `None` if it is not known beforehand.
    ///
    /// A file that is cut off may hand out fewer before it ends with an error.
    fn frame_count(&self) -> Option<u64>;

    /// The number of the last frame, or `None` where that is not known beforehand.
    ///
    /// A file that is cut off may end before it.
    fn last_sequence(&self) -> Option<u64> {
        None
    }

    /// Columns and rows of every frame, px.
    fn size(&self) -> (usize, usize);

    /// Whether the colour of the frames is stored at their resolution. Where it is not, as in most videos and JPEG images,
    /// flow from colour has several times the error of flow from grey. Frames of cameras whose colour is coarse are grey
    /// ([`CameraFrameDecoder::for_tracking`](crate::CameraFrameDecoder::for_tracking)).
    fn has_full_colour(&self) -> bool {
        true
    }

    /// Whether flow should be computed from the colour of frames such as this one: they have colour, at their resolution.
    fn tracks_in_colour(&self, pixels: &Pixels) -> bool {
        pixels.is_colour() && self.has_full_colour()
    }

    /// One line for logs and reports: where the frames come from and what they are.
    fn description(&self) -> String;

    /// The truth of the frame that came last, if a simulation made it.
    fn truth(&self) -> Option<FrameTruth> {
        None
    }

    /// The scene that a simulation shows, as TOML; of several, the first.
    fn scene_toml(&self) -> Option<String> {
        None
    }

    /// Remarks about unusual properties of the source that do not prevent reading, one sentence each.
    fn remarks(&self) -> Vec<String> {
        Vec::new()
    }
}

/// What a simulation knows of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameTruth {
    /// Indentation depth of the indenter, mm.
    pub depth_mm: f64,
    /// Force of the indenter on the gel `(x, y, z)`, N.
    pub force_n: [f64; 3],
    /// Torque on the gel about z through the centre of contact, N mm.
    pub torque_nmm: f64,
}

/// Options for reading a source.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// Nominal rate of an image folder, frames per second. Frame `n` gets the time `n / frames_per_second`: files carry
    /// no capture time, so the time is only as true as this rate. Videos carry their own times and ignore it.
    pub frames_per_second: f64,
}

/// Rates that a recording can have, frames per second: from one frame in some days to a million a second.
const RATES: std::ops::RangeInclusive<f64> = 1e-6..=1e6;

impl Default for Options {
    fn default() -> Self {
        Self { frames_per_second: 30.0 }
    }
}

impl Options {
    /// Checks that every value makes sense.
    ///
    /// # Errors
    ///
    /// [`SourceError::Rate`] if the rate is not from 1e-6 to 1e6 frames per second.
    pub fn validate(&self) -> Result<(), SourceError> {
        let rate = self.frames_per_second;
        if RATES.contains(&rate) { Ok(()) } else { Err(SourceError::Rate { frames_per_second: rate }) }
    }
}

//! Checks whether a recording can be used for a calibration, and if not, what to change.
//!
//! A check takes the frames one by one, then gives a [`RecordingCheck`] with the measured values and the fault, if
//! there is one. Only the first cause is reported: an image that is too dark is not also reported as blurred, and a
//! blurred one is not also reported as moving too little.

mod board;
mod exposure;
mod fault;
mod image_quality;
mod press;
mod rest;
mod samples;
mod still;
mod thresholds;

use fingervision_image::Frame;

pub use board::{BOARD_IMAGES, BoardCheck};
pub use fault::{Fault, RecordingCheck, What};
pub use image_quality::ImageQuality;
pub use press::PressCheck;
pub use still::{STILL_IMAGES, StillCheck};

/// Takes the frames of a recording in order, then judges it.
pub trait Check {
    /// Takes the next frame.
    fn push(&mut self, frame: &Frame);

    /// The result for the frames so far.
    fn finish(self: Box<Self>) -> RecordingCheck;
}

//! Whether a recording is fit for a calibration, and if not, what to do again and why.
//!
//! A check is given the frames one by one, then gives a [`RecordingCheck`]: what was measured and what is wrong. Only the
//! first cause is named: an image too dark is not called unsharp as well, an unsharp one is not said to move too little.

mod board;
mod exposure;
mod fault;
mod press;
mod rest;
mod samples;
mod still;

use fingervision_image::Frame;

pub use board::{BOARD_IMAGES, BoardCheck};
pub use fault::{Fault, RecordingCheck, What};
pub use press::PressCheck;
pub use still::{STILL_IMAGES, StillCheck};

/// Takes the frames of a recording in order, then judges it.
pub trait Check {
    /// Takes the next frame.
    fn push(&mut self, frame: &Frame);

    /// What the frames so far are worth.
    fn finish(self: Box<Self>) -> RecordingCheck;
}

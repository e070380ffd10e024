//! The interface of everything that takes readings.

use fingervision_image::Frame;
use fingervision_touch::Reading;

use crate::SinkError;

/// A receiver of readings; it gets every reading of a run, in order.
pub trait Sink {
    /// Takes one reading and the frame that it was computed from.
    ///
    /// # Errors
    ///
    /// [`SinkError`] if the reading does not fit the previous ones or cannot be written. Earlier readings are kept.
    fn write(&mut self, reading: &Reading, frame: &Frame) -> Result<(), SinkError>;
}

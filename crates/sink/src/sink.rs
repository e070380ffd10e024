//! What every taker of readings has in common.

use fingervision_image::Frame;
use fingervision_touch::Reading;

use crate::SinkError;

/// A taker of readings; it is handed every reading of a run, in order.
pub trait Sink {
    /// Takes one reading and the frame that it was computed from.
    ///
    /// # Errors
    ///
    /// [`SinkError`] if the reading does not fit the ones before it or cannot be written. What was taken before stays.
    fn write(&mut self, reading: &Reading, frame: &Frame) -> Result<(), SinkError>;
}

//! What a recording has to know of a sensor.

use fingervision_pipeline::SensorHandle;
use fingervision_touch::Profile;

/// A sensor whose frames and readings are recorded.
#[derive(Debug, Clone)]
pub struct RecordedSensor {
    /// Its name.
    pub name: String,
    /// One line that describes the source of its frames.
    pub description: String,
    /// The profile in use.
    pub profile: Profile,
    /// Columns and rows of its frames, px.
    pub frame_size: (usize, usize),
    /// The clock of the messages' times.
    pub clock: Clock,
}

/// The clock from which the time of a message is taken. The source's own times are stored in any case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Clock {
    /// The host's clock at the capture of a frame: for cameras.
    Host,
    /// The source's times, counted from the beginning of the recording: for files and simulated presses, which are read
    /// as fast as they are tracked.
    Source,
}

impl RecordedSensor {
    /// A sensor of a pipeline.
    #[must_use]
    pub fn of(handle: &SensorHandle, clock: Clock) -> Self {
        Self {
            name: handle.name().into(),
            description: handle.description().into(),
            profile: handle.profile().clone(),
            frame_size: handle.frame_size(),
            clock,
        }
    }
}

//! Recordings: the frames of sensors and their readings, in MCAP files.
//!
//! A recording contains, for each sensor, every frame bit for bit, its number and time, the readings, the events and
//! the profile; for simulated sensors also the truth. Tracking a recording gives the same fields as tracking the source.
//! Programs for robot data can show it: pictures, points, camera and events have Foxglove's schemas, and every schema is
//! in the file.
//!
//! - [`RecordingWriter`] writes a file and only appends to it: if the program is killed, less than the last second is
//!   missing.
//! - [`RecorderThread`] records the sensors of a pipeline, from a subscription.
//! - [`LiveMessages`] makes the same messages for a program that shows them live.
//! - [`Recording`] opens a file, complete or cut off; [`RecordingSource`] provides the frames of a sensor.
//!
//! ```no_run
//! use fingervision_recording::{Recording, RecordingSource};
//! use fingervision_source::Source;
//!
//! let recording = Recording::open("press.mcap".as_ref())?;
//! let sensor = recording.sensor(None)?;
//! let profile = recording.profile(sensor)?;
//! let mut source = RecordingSource::open(recording, sensor)?;
//! while let Some(frame) = source.next_frame()? {
//!     println!("frame {} at {} s", frame.sequence, frame.capture_time_s);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod coding;
mod container;
mod error;
mod live_messages;
mod lossless;
mod message;
mod message_reader;
mod numbers;
mod recorded_sensor;
mod recorder;
mod recording;
mod recording_source;
mod schema;
mod sensor_messages;
mod topic;
mod view;
mod writer;

pub use error::RecordingError;
pub use live_messages::{LiveChannel, LiveMessages, LiveSink};
pub use recorded_sensor::{Clock, RecordedSensor};
pub use recorder::{RecorderOptions, RecorderProgress, RecorderThread};
pub use recording::{RecordedTruth, Recording, RecordingSensor};
pub use recording_source::RecordingSource;
pub use writer::RecordingWriter;

//! Writes a recording: unchanged frames, readings, events, and messages for other programs' displays.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use fingervision_pipeline::host_time_s;
use fingervision_source::{EncodedFrame, FrameTruth};
use fingervision_touch::{Reading, ReadingNumbers};

use crate::container::writer::{Stamp, Writer};
use crate::lossless::Encoder;
use crate::sensor_messages::{MessageSink, SensorMessages, Times};
use crate::topic::{Topic, prefixes};
use crate::{RecordedSensor, RecordingError};

/// The name of the metadata that describe a sensor.
pub(crate) const SENSOR_METADATA: &str = "fingervision.sensor";
/// The name of the profile in a file, behind the sensor's prefix.
pub(crate) const PROFILE_NAME: &str = "profile.toml";
/// The name of a simulated sensor's scene in a file, behind the sensor's prefix.
pub(crate) const SCENE_NAME: &str = "scene.toml";

/// A recording that is being written. If it is dropped without [`finish`](Self::finish), its last half second and its
/// index are missing; the rest can be read.
#[derive(Debug)]
pub struct RecordingWriter<W = File> {
    path: PathBuf,
    to: Writer<W>,
    sensors: Vec<SensorMessages>,
    prefixes: Vec<String>,
    encoder: Encoder,
}

impl<W: Write> MessageSink for Writer<W> {
    fn wants(&self, _channel: u16) -> bool {
        true
    }

    fn message(&mut self, stamp: Stamp, fill: impl FnOnce(&mut Vec<u8>)) -> io::Result<()> {
        self.message(stamp, fill)
    }
}

impl RecordingWriter {
    /// Creates a file, or empties it.
    ///
    /// # Errors
    ///
    /// [`RecordingError::Write`] if the file cannot be written.
    pub fn create(path: &Path, sensors: &[RecordedSensor]) -> Result<Self, RecordingError> {
        let file = File::create(path).map_err(RecordingError::writing(path))?;
        Self::new(file, path, sensors)
    }

    /// Closes the recording and flushes it to the disk; returns its length, bytes.
    ///
    /// # Errors
    ///
    /// [`RecordingError::Write`] if it cannot be written.
    pub fn finish(self) -> Result<u64, RecordingError> {
        let Self { path, to, .. } = self;
        let len = |file: File| file.sync_all().and_then(|()| file.metadata()).map(|metadata| metadata.len());
        to.finish().and_then(len).map_err(RecordingError::writing(&path))
    }
}

impl<W: Write> RecordingWriter<W> {
    /// Begins a recording; `path` is its name in errors.
    ///
    /// # Errors
    ///
    /// [`RecordingError::Write`] if it cannot be written.
    pub fn new(to: W, path: &Path, sensors: &[RecordedSensor]) -> Result<Self, RecordingError> {
        let writing = |error| RecordingError::Write { path: path.to_owned(), error };
        let library = concat!("fingervision ", env!("CARGO_PKG_VERSION"));
        let mut to = Writer::new(to, library).map_err(writing)?;
        let mut schemas = Vec::new();
        for topic in Topic::ALL {
            let schema = topic.schema();
            schemas.push(to.schema(schema.name, &schema.descriptors()).map_err(writing)?);
        }
        let prefixes = prefixes(sensors.iter().map(|sensor| sensor.name.as_str()));
        for prefix in &prefixes {
            for (topic, schema) in Topic::ALL.into_iter().zip(&schemas) {
                to.channel(*schema, &topic.of(prefix)).map_err(writing)?;
            }
        }
        let states = messages_of(sensors, &prefixes);
        let mut writer = Self { path: path.to_owned(), to, sensors: states, prefixes, encoder: Encoder::default() };
        for (index, sensor) in sensors.iter().enumerate() {
            writer.describe(index, sensor).map_err(writing)?;
        }
        Ok(writer)
    }

    /// Writes the data that do not change: the profile, the name, the camera.
    fn describe(&mut self, index: usize, sensor: &RecordedSensor) -> io::Result<()> {
        let (to, state, prefix) = (&mut self.to, &self.sensors[index], self.prefixes[index].as_str());
        let pairs = [("name", sensor.name.as_str()), ("topics", prefix), ("source", sensor.description.as_str())];
        to.metadata(SENSOR_METADATA, &pairs)?;
        let (name, text) = (format!("{prefix}/{PROFILE_NAME}"), sensor.profile.to_toml());
        to.attachment(&name, "application/toml", state.last_ns(), text.as_bytes())?;
        state.describe(&sensor.profile, sensor.frame_size, to)?;
        to.flush()
    }

    /// Adds the scene that a simulated sensor shows, as TOML.
    ///
    /// # Errors
    ///
    /// As [`Self::write_frame`].
    ///
    /// # Panics
    ///
    /// If there is no sensor of this index.
    pub fn write_scene(&mut self, sensor: usize, scene_toml: &str) -> Result<(), RecordingError> {
        let (name, time_ns) = (format!("{}/{SCENE_NAME}", self.prefixes[sensor]), self.sensors[sensor].last_ns());
        let done = self.to.attachment(&name, "application/toml", time_ns, scene_toml.as_bytes());
        done.map_err(RecordingError::writing(&self.path))
    }

    /// Adds a frame, captured at this time of [`host_time_s`], unchanged: JPEG as an image, others without loss, and
    /// small pictures of these at a limited rate.
    ///
    /// # Errors
    ///
    /// [`RecordingError::Write`] if it cannot be written. What was written before can be read; nothing more is written.
    ///
    /// # Panics
    ///
    /// If there is no sensor of this index.
    pub fn write_frame(&mut self, sensor: usize, frame: &EncodedFrame, captured_s: f64) -> Result<(), RecordingError> {
        let done = self.sensors[sensor].frame(frame, captured_s, &mut self.encoder, &mut self.to);
        self.end(done)
    }

    /// Adds an earlier frame, captured at `captured_s`, to which the readings that follow are relative. Its message has
    /// other times, on the source's clock and of [`host_time_s`]: those of the frame that follows.
    ///
    /// # Errors
    ///
    /// As [`Self::write_frame`].
    ///
    /// # Panics
    ///
    /// As [`Self::write_frame`].
    pub fn write_reference(
        &mut self,
        sensor: usize,
        frame: &EncodedFrame,
        captured_s: f64,
        (next_time_s, next_captured_s): (f64, f64),
    ) -> Result<(), RecordingError> {
        let times = Times { captured_s: next_captured_s, capture_time_s: next_time_s };
        let done = self.sensors[sensor].frame_at(times, frame, captured_s, &mut self.encoder, &mut self.to);
        self.end(done)
    }

    /// Adds what a simulation knows of the frame with this number and this time of the source.
    ///
    /// # Errors
    ///
    /// As [`Self::write_frame`].
    pub fn write_truth(
        &mut self,
        sensor: usize,
        (sequence, capture_time_s): (u64, f64),
        truth: &FrameTruth,
        captured_s: f64,
    ) -> Result<(), RecordingError> {
        let times = Times { captured_s, capture_time_s };
        let done = self.sensors[sensor].truth(sequence, truth, times, &mut self.to);
        self.end(done)
    }

    /// Adds the numbers of a reading, whose frame was captured at this time of [`host_time_s`].
    ///
    /// # Errors
    ///
    /// As [`Self::write_frame`].
    pub fn write_reading(
        &mut self,
        sensor: usize,
        numbers: &ReadingNumbers,
        captured_s: f64,
    ) -> Result<(), RecordingError> {
        let done = self.sensors[sensor].reading(numbers, captured_s, &mut self.to);
        self.end(done)
    }

    /// Adds the surface of a whole reading as points, for other programs' displays. Does nothing without depth or
    /// without a camera in the profile.
    ///
    /// # Errors
    ///
    /// As [`Self::write_frame`].
    pub fn write_surface(&mut self, sensor: usize, reading: &Reading, captured_s: f64) -> Result<(), RecordingError> {
        let done = self.sensors[sensor].surface(reading, captured_s, &mut self.to);
        self.end(done)
    }

    /// Adds something that a user should know, as a sentence, at this time of [`host_time_s`].
    ///
    /// # Errors
    ///
    /// As [`Self::write_frame`].
    pub fn write_event(&mut self, sensor: usize, text: &str, host_time_s: f64) -> Result<(), RecordingError> {
        let done = self.sensors[sensor].event(text, host_time_s, &mut self.to);
        self.end(done)
    }

    /// Writes messages that have waited for half a second. To be called while no message arrives.
    ///
    /// # Errors
    ///
    /// As [`Self::write_frame`].
    pub fn flush_due(&mut self) -> Result<(), RecordingError> {
        self.end(Ok(()))
    }

    /// Bytes in the file so far.
    #[must_use]
    pub fn bytes_written(&self) -> u64 {
        self.to.written_bytes()
    }

    /// Writes a chunk that is due after what was added.
    fn end(&mut self, added: io::Result<()>) -> Result<(), RecordingError> {
        added.and_then(|()| self.to.flush_due()).map_err(RecordingError::writing(&self.path))
    }
}

/// What makes the messages of sensors whose topics begin with these prefixes.
pub(crate) fn messages_of(sensors: &[RecordedSensor], prefixes: &[String]) -> Vec<SensorMessages> {
    let since_1970_s = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs_f64();
    let host_now_s = host_time_s();
    let of = |(index, (sensor, prefix)): (usize, (&RecordedSensor, &String))| {
        SensorMessages::new(sensor, prefix, index, since_1970_s, host_now_s)
    };
    sensors.iter().zip(prefixes).enumerate().map(of).collect()
}

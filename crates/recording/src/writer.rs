//! Writes a recording: unchanged frames, readings, events, and messages for other programs' displays.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use fingervision_optics::Camera;
use fingervision_pipeline::{SensorHandle, host_time_s};
use fingervision_source::{CameraCoding, EncodedFrame};
use fingervision_touch::{Profile, Reading, ReadingNumbers};
use prost::Message;

use crate::container::writer::{Stamp, Writer};
use crate::lossless::{Encoder, Storage};
use crate::message::{CompressedImage, Frame, Log, put_with_bytes, timestamp};
use crate::topic::{Topic, prefixes};
use crate::{RecordingError, coding, numbers, schema, view};

/// Time between two previews of a sensor, s.
const PREVIEW_PERIOD_S: f64 = 0.1;

/// The name of the metadata that describe a sensor.
pub(crate) const SENSOR_METADATA: &str = "fingervision.sensor";
/// The name of the profile in a file, behind the sensor's prefix.
pub(crate) const PROFILE_NAME: &str = "profile.toml";

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

/// A recording that is being written. If it is dropped without [`finish`](Self::finish), its last half second and its
/// index are missing; the rest can be read.
#[derive(Debug)]
pub struct RecordingWriter<W = File> {
    path: PathBuf,
    to: Writer<W>,
    sensors: Vec<SensorState>,
    /// The time 0 of the host's clock, s since 1970.
    host_start_s: f64,
    encoder: Encoder,
}

#[derive(Debug)]
struct SensorState {
    name: String,
    clock: Clock,
    camera: Option<Camera>,
    /// The first channel; a channel for each topic follows.
    first_channel: u16,
    /// Number of image messages so far.
    images: u32,
    /// Time of the first frame, on the source's clock and on the host's, s.
    start_s: Option<[f64; 2]>,
    /// Time of the last message, ns.
    last_ns: u64,
    /// When the next preview is due, s.
    preview_due_s: f64,
    image: CompressedImage,
    frame: Frame,
    frame_ids: [String; 2],
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
        let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let host_start_s = since_1970.as_secs_f64() - host_time_s();
        let mut states = Vec::new();
        let prefixes = prefixes(sensors.iter().map(|sensor| sensor.name.as_str()));
        for (sensor, prefix) in sensors.iter().zip(&prefixes) {
            let first_channel = (Topic::ALL.len() * states.len()) as u16;
            for (topic, schema) in Topic::ALL.into_iter().zip(&schemas) {
                to.channel(*schema, &topic.of(prefix)).map_err(writing)?;
            }
            states.push(SensorState::new(sensor, prefix, first_channel, since_1970.as_nanos() as u64));
        }
        let mut writer = Self { path: path.to_owned(), to, sensors: states, host_start_s, encoder: Encoder::default() };
        for (index, (sensor, prefix)) in sensors.iter().zip(&prefixes).enumerate() {
            writer.describe(index, sensor, prefix)?;
        }
        Ok(writer)
    }

    /// Writes the data that do not change: the profile, the name, the camera.
    fn describe(&mut self, index: usize, sensor: &RecordedSensor, prefix: &str) -> Result<(), RecordingError> {
        let (path, to) = (&self.path, &mut self.to);
        let writing = |error| RecordingError::Write { path: path.clone(), error };
        let state = &self.sensors[index];
        let (time_ns, [camera_id, gel_id]) = (state.last_ns, &state.frame_ids);
        let pairs = [("name", sensor.name.as_str()), ("topics", prefix), ("source", sensor.description.as_str())];
        to.metadata(SENSOR_METADATA, &pairs).map_err(writing)?;
        let (name, text) = (format!("{prefix}/{PROFILE_NAME}"), sensor.profile.to_toml());
        to.attachment(&name, "application/toml", time_ns, text.as_bytes()).map_err(writing)?;
        if let Some(message) = view::calibration(&sensor.profile, sensor.frame_size, time_ns, camera_id) {
            to.message(state.stamp(Topic::Calibration, time_ns), |into| message.encode_raw(into)).map_err(writing)?;
        }
        if let Some(message) = view::transform(&sensor.profile, time_ns, [camera_id, gel_id]) {
            to.message(state.stamp(Topic::Transform, time_ns), |into| message.encode_raw(into)).map_err(writing)?;
        }
        to.flush().map_err(writing)
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
    /// If there is no sensor of this index, as in the other functions.
    pub fn write_frame(&mut self, sensor: usize, frame: &EncodedFrame, captured_s: f64) -> Result<(), RecordingError> {
        let (to, state, encoder) = (&mut self.to, &mut self.sensors[sensor], &mut self.encoder);
        let time_ns = state.time_ns(self.host_start_s, captured_s, frame.capture_time_s);
        let path = &self.path;
        let writing = |error| RecordingError::Write { path: path.clone(), error };
        if frame.layout.coding == CameraCoding::MotionJpeg {
            state.image.timestamp = Some(timestamp(time_ns));
            let stamp = state.stamp(Topic::Image, time_ns);
            to.message(stamp, |into| put_with_bytes(&state.image, 2, &frame.bytes, into)).map_err(writing)?;
            state.take_frame(frame, captured_s, time_ns, Storage::Image);
            let stamp = state.stamp(Topic::Frame, time_ns);
            to.message(stamp, |into| state.frame.encode_raw(into)).map_err(writing)?;
            state.images += 1;
        } else {
            let (storage, stored) = encoder.encode(frame.layout, &frame.bytes);
            state.take_frame(frame, captured_s, time_ns, storage);
            let stamp = state.stamp(Topic::Frame, time_ns);
            to.message(stamp, |into| put_with_bytes(&state.frame, 13, stored, into)).map_err(writing)?;
            let time_s = 1e-9 * time_ns as f64;
            if time_s >= state.preview_due_s {
                state.preview_due_s = time_s + PREVIEW_PERIOD_S;
                if let Some(image) = view::preview(frame, time_ns, &state.frame_ids[0]) {
                    let stamp = state.stamp(Topic::Preview, time_ns);
                    to.message(stamp, |into| image.encode_raw(into)).map_err(writing)?;
                }
            }
        }
        to.flush_due().map_err(writing)
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
        let state = &mut self.sensors[sensor];
        let time_ns = state.time_ns(self.host_start_s, captured_s, numbers.capture_time_s);
        let message = numbers::to_message(numbers, captured_s, time_ns);
        self.put(sensor, Topic::Reading, time_ns, &message)
    }

    /// Adds the surface of a whole reading as points, for other programs' displays. Does nothing without depth or
    /// without a camera in the profile.
    ///
    /// # Errors
    ///
    /// As [`Self::write_frame`].
    pub fn write_surface(&mut self, sensor: usize, reading: &Reading, captured_s: f64) -> Result<(), RecordingError> {
        let state = &mut self.sensors[sensor];
        let time_ns = state.time_ns(self.host_start_s, captured_s, reading.capture_time_s);
        let Some(camera) = &state.camera else { return Ok(()) };
        let Some(message) = view::surface(reading, camera, time_ns, &state.frame_ids[1]) else { return Ok(()) };
        self.put(sensor, Topic::Surface, time_ns, &message)
    }

    /// Adds something that a user should know, as a sentence, at this time of [`host_time_s`].
    ///
    /// # Errors
    ///
    /// As [`Self::write_frame`].
    pub fn write_event(&mut self, sensor: usize, text: &str, host_time_s: f64) -> Result<(), RecordingError> {
        let state = &self.sensors[sensor];
        let time_ns = match state.clock {
            Clock::Host => nanoseconds(self.host_start_s + host_time_s),
            Clock::Source => state.last_ns,
        };
        let message = Log {
            timestamp: Some(timestamp(time_ns)),
            level: schema::INFO,
            message: text.into(),
            name: state.name.clone(),
            file: String::new(),
            line: 0,
        };
        self.put(sensor, Topic::Log, time_ns, &message)
    }

    /// Writes messages that have waited for half a second. To be called while no message arrives.
    ///
    /// # Errors
    ///
    /// As [`Self::write_frame`].
    pub fn flush_due(&mut self) -> Result<(), RecordingError> {
        self.to.flush_due().map_err(RecordingError::writing(&self.path))
    }

    /// Bytes in the file so far.
    #[must_use]
    pub fn bytes_written(&self) -> u64 {
        self.to.written_bytes()
    }

    fn put(&mut self, sensor: usize, topic: Topic, ns: u64, message: &impl Message) -> Result<(), RecordingError> {
        let stamp = self.sensors[sensor].stamp(topic, ns);
        let done = self.to.message(stamp, |into| message.encode_raw(into)).and_then(|()| self.to.flush_due());
        done.map_err(RecordingError::writing(&self.path))
    }
}

impl SensorState {
    fn new(sensor: &RecordedSensor, prefix: &str, first_channel: u16, now_ns: u64) -> Self {
        let frame_ids = [format!("{prefix}/camera"), format!("{prefix}/gel")];
        let (format, frame_id) = ("jpeg".into(), frame_ids[0].clone());
        Self {
            name: sensor.name.clone(),
            clock: sensor.clock,
            camera: sensor.profile.camera.and_then(|params| Camera::new(&params).ok()),
            first_channel,
            images: 0,
            start_s: None,
            last_ns: now_ns,
            preview_due_s: 0.0,
            image: CompressedImage { format, frame_id, ..CompressedImage::default() },
            frame: Frame::default(),
            frame_ids,
        }
    }

    fn stamp(&self, topic: Topic, time_ns: u64) -> Stamp {
        Stamp { channel: self.first_channel + topic as u16, time_ns }
    }

    /// The time of a message about a frame with these times, ns since 1970.
    fn time_ns(&mut self, host_start_s: f64, captured_s: f64, capture_time_s: f64) -> u64 {
        let host_s = host_start_s + captured_s;
        let [first_s, start_s] = *self.start_s.get_or_insert([capture_time_s, host_s]);
        self.last_ns = match self.clock {
            Clock::Host => nanoseconds(host_s),
            Clock::Source => nanoseconds(start_s + capture_time_s - first_s),
        };
        self.last_ns
    }

    /// Fills the message that describes a frame; its bytes follow behind it.
    fn take_frame(&mut self, frame: &EncodedFrame, captured_s: f64, time_ns: u64, storage: Storage) {
        let layout = frame.layout;
        let message = &mut self.frame;
        message.timestamp = Some(timestamp(time_ns));
        message.sequence = frame.sequence;
        (message.capture_time_s, message.captured_s) = (frame.capture_time_s, captured_s);
        (message.width, message.height) = (layout.width as u32, layout.height as u32);
        message.row_bytes = layout.row_bytes as u32;
        for (text, name) in [(&mut message.coding, coding::name(layout.coding)), (&mut message.storage, storage.name())]
        {
            text.clear();
            text.push_str(name);
        }
        message.image = if storage == Storage::Image { self.images } else { 0 };
        message.length = frame.bytes.len() as u64;
        message.crc32 = crc32fast::hash(&frame.bytes);
    }
}

fn nanoseconds(time_s: f64) -> u64 {
    (1e9 * time_s).round() as u64
}

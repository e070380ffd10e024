//! Opens a recording: which sensors it has, their profiles, frames and readings.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use fingervision_source::{CameraLayout, EncodedFrame};
use fingervision_touch::{Profile, ProfileError, ReadingNumbers};
use prost::Message;

use crate::container::scan::{Contents, Place, scan};
use crate::lossless::{self, Storage};
use crate::message::{CompressedImage, Frame, Log, Reading};
use crate::topic::Topic;
use crate::writer::{PROFILE_NAME, SENSOR_METADATA};
use crate::{RecordingError, coding, numbers};

/// The first bytes of every recording.
const SIGNATURE: [u8; 8] = *b"\x89MCAP0\r\n";

/// An open recording. Its contents are known; frames are read when they are requested.
#[derive(Debug, Clone)]
pub struct Recording {
    path: PathBuf,
    contents: Arc<Contents>,
    sensors: Vec<RecordingSensor>,
}

/// A sensor of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingSensor {
    /// Its name.
    pub name: String,
    /// One line that describes the source of its frames.
    pub source: String,
    /// Number of its frames.
    pub frames: u64,
    /// Number of its readings.
    pub readings: u64,
    /// Number of its events.
    pub events: u64,
    /// Time from its first frame to its last, s.
    pub duration_s: f64,
    prefix: String,
}

/// Reads the messages of a recording.
#[derive(Debug)]
pub(crate) struct MessageReader {
    file: File,
    bytes: Vec<u8>,
    image: CompressedImage,
}

impl Recording {
    /// Opens a file. If its end is cut off, because the program was killed or the disk was full, everything before can
    /// be read.
    ///
    /// # Errors
    ///
    /// [`RecordingError::Read`] if the file cannot be read, [`RecordingError::NotARecording`] if it has no sensors.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        let file = File::open(path).map_err(RecordingError::reading(path))?;
        let contents = scan(file).map_err(RecordingError::reading(path))?;
        let refused = |reason: String| RecordingError::NotARecording { path: path.to_owned(), reason };
        let contents = contents.ok_or_else(|| refused("it does not begin as an MCAP file does".into()))?;
        if let Some(compression) = &contents.compression {
            let reason =
                format!("its chunks are compressed ({compression}); `mcap compress --compression none` makes a copy");
            return Err(refused(reason));
        }
        let sensors = sensors(&contents);
        if sensors.is_empty() {
            return Err(refused("it describes no sensor, or it ends too early".into()));
        }
        Ok(Self { path: path.to_owned(), contents: Arc::new(contents), sensors })
    }

    /// Whether a file begins as a recording does; false if it cannot be read.
    #[must_use]
    pub fn is_at(path: &Path) -> bool {
        let mut signature = [0; SIGNATURE.len()];
        path.is_file()
            && File::open(path).and_then(|mut file| file.read_exact(&mut signature)).is_ok()
            && signature == SIGNATURE
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The sensors, in the order in which they were recorded.
    #[must_use]
    pub fn sensors(&self) -> &[RecordingSensor] {
        &self.sensors
    }

    /// The index of a sensor; without a name, of the only one.
    ///
    /// # Errors
    ///
    /// [`RecordingError::Sensor`] if there is no sensor of this name, or no name is given and there are several
    /// sensors.
    pub fn sensor(&self, name: Option<&str>) -> Result<usize, RecordingError> {
        let is_wanted = |sensor: &RecordingSensor| name.is_none_or(|name| sensor.name == name);
        let mut found = (0..self.sensors.len()).filter(|index| self.sensors.get(*index).is_some_and(is_wanted));
        match (found.next(), found.next()) {
            (Some(index), None) => Ok(index),
            (Some(index), Some(_)) if name.is_some() => Ok(index),
            _ => {
                let sensors = self.sensors.iter().map(|sensor| sensor.name.clone()).collect();
                Err(RecordingError::Sensor { path: self.path.clone(), wanted: name.map(Into::into), sensors })
            }
        }
    }

    /// The profile with which a sensor was tracked; `None` if it is not in the file.
    ///
    /// # Errors
    ///
    /// [`ProfileError`] if this version does not accept it.
    pub fn profile(&self, sensor: usize) -> Result<Option<Profile>, ProfileError> {
        let Some(sensor) = self.sensors.get(sensor) else { return Ok(None) };
        let name = format!("{}/{PROFILE_NAME}", sensor.prefix);
        let attachment = self.contents.attachments.iter().find(|attachment| attachment.name == name);
        let text = attachment.and_then(|attachment| std::str::from_utf8(&attachment.data).ok());
        text.map(Profile::from_toml).transpose()
    }

    /// Sentences on what is unusual: the file was not closed, or is damaged.
    #[must_use]
    pub fn remarks(&self) -> Vec<String> {
        let path = self.path.display();
        if let Some(fault) = &self.contents.fault {
            return vec![format!("{path} is damaged: {fault}; what could be read is used")];
        }
        if self.is_cut_off() {
            return vec![format!("{path} was not closed; the last second before it ended may be missing")];
        }
        Vec::new()
    }

    /// Whether the end of the file is missing.
    #[must_use]
    pub fn is_cut_off(&self) -> bool {
        !self.contents.is_closed
    }

    /// The numbers of all readings of a sensor, in order. Damaged ones are left out.
    ///
    /// # Errors
    ///
    /// [`RecordingError::Read`] if the system refuses.
    pub fn readings(&self, sensor: usize) -> Result<Vec<ReadingNumbers>, RecordingError> {
        let messages = self.messages::<Reading>(sensor, Topic::Reading)?;
        Ok(messages.iter().map(numbers::from_message).collect())
    }

    /// The events of a sensor, in order.
    ///
    /// # Errors
    ///
    /// [`RecordingError::Read`] if the system refuses.
    pub fn events(&self, sensor: usize) -> Result<Vec<String>, RecordingError> {
        Ok(self.messages::<Log>(sensor, Topic::Log)?.into_iter().map(|log| log.message).collect())
    }

    fn messages<M: Message + Default>(&self, sensor: usize, topic: Topic) -> Result<Vec<M>, RecordingError> {
        let mut reader = self.reader()?;
        let mut messages = Vec::new();
        for place in self.places(sensor, topic) {
            let bytes = reader.read(*place).map_err(RecordingError::reading(&self.path))?;
            messages.extend(M::decode(bytes).ok());
        }
        Ok(messages)
    }

    pub(crate) fn reader(&self) -> Result<MessageReader, RecordingError> {
        let file = File::open(&self.path).map_err(RecordingError::reading(&self.path))?;
        Ok(MessageReader { file, bytes: Vec::new(), image: CompressedImage::default() })
    }

    /// The positions of the messages of a topic.
    pub(crate) fn places(&self, sensor: usize, topic: Topic) -> &[Place] {
        self.sensors.get(sensor).map_or(&[], |sensor| places(&self.contents, &sensor.prefix, topic))
    }
}

fn sensors(contents: &Contents) -> Vec<RecordingSensor> {
    let described = contents.metadata.iter().filter(|(name, _)| name == SENSOR_METADATA);
    let of_pairs = |(_, pairs): &(String, Vec<(String, String)>)| {
        let value = |wanted: &str| pairs.iter().find(|(key, _)| key == wanted).map(|(_, value)| value.clone());
        let prefix = value("topics")?;
        let frames = places(contents, &prefix, Topic::Frame);
        let count = |topic| places(contents, &prefix, topic).len() as u64;
        let duration_ns = match (frames.first(), frames.last()) {
            (Some(first), Some(last)) => last.time_ns.saturating_sub(first.time_ns),
            _ => 0,
        };
        Some(RecordingSensor {
            name: value("name")?,
            source: value("source").unwrap_or_default(),
            frames: frames.len() as u64,
            readings: count(Topic::Reading),
            events: count(Topic::Log),
            duration_s: 1e-9 * duration_ns as f64,
            prefix,
        })
    };
    described.filter_map(of_pairs).collect()
}

fn places<'a>(contents: &'a Contents, prefix: &str, topic: Topic) -> &'a [Place] {
    let topic = topic.of(prefix);
    let channel = contents.channels.iter().find(|channel| channel.topic == topic);
    channel.map_or(&[], |channel| &channel.messages)
}

impl MessageReader {
    /// The data of a message. Its position lies inside the file, so its length is limited by that of the file.
    pub(crate) fn read(&mut self, place: Place) -> std::io::Result<&[u8]> {
        self.file.seek(SeekFrom::Start(place.offset))?;
        self.bytes.resize(place.len as usize, 0);
        self.file.read_exact(&mut self.bytes)?;
        Ok(&self.bytes)
    }

    /// Reads the original bytes of a frame; `images` are the positions of the sensor's image messages.
    ///
    /// # Errors
    ///
    /// A sentence on what is wrong with it.
    pub(crate) fn frame(&mut self, place: Place, images: &[Place], into: &mut EncodedFrame) -> Result<(), String> {
        let bytes = self.read(place).map_err(|error| error.to_string())?;
        let message = Frame::decode(bytes).map_err(|_| "its message is damaged")?;
        let coding =
            coding::of(&message.coding).ok_or_else(|| format!("the coding {} is not known", message.coding))?;
        let (width, height) = (message.width as usize, message.height as usize);
        into.layout = CameraLayout { coding, width, height, row_bytes: message.row_bytes as usize };
        (into.sequence, into.capture_time_s) = (message.sequence, message.capture_time_s);
        let storage = Storage::of(&message.storage).ok_or_else(|| format!("stored as {}", message.storage))?;
        let len = usize::try_from(message.length).map_err(|_| "its length is impossible")?;
        match storage {
            Storage::Raw => into.bytes = message.data,
            Storage::WebP => lossless::decode(into.layout, len, &message.data, &mut into.bytes)?,
            Storage::Image => {
                let found = images.binary_search_by_key(&message.image, |place| place.number);
                let place = found.ok().and_then(|index| images.get(index)).ok_or("its image is missing")?;
                self.image(*place, &mut into.bytes)?;
            }
        }
        if into.bytes.len() != len || crc32fast::hash(&into.bytes) != message.crc32 {
            return Err("its bytes are damaged".into());
        }
        Ok(())
    }

    fn image(&mut self, place: Place, into: &mut Vec<u8>) -> Result<(), String> {
        self.read(place).map_err(|error| error.to_string())?;
        self.image.clear();
        self.image.merge(self.bytes.as_slice()).map_err(|_| "its image is damaged")?;
        std::mem::swap(into, &mut self.image.data);
        Ok(())
    }
}

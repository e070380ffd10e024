//! Opens a recording: which sensors it has, their profiles, frames and readings.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use fingervision_source::FrameTruth;
use fingervision_touch::{Profile, ProfileError, ReadingNumbers};
use prost::Message;

use crate::container::scan::{Contents, Place, scan};
use crate::message::{Frame, Log, Reading, Truth};
use crate::message_reader::MessageReader;
use crate::topic::Topic;
use crate::writer::{PROFILE_NAME, SCENE_NAME, SENSOR_METADATA};
use crate::{RecordingError, numbers};

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

/// The truth of a frame of a simulation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordedTruth {
    /// The frame's number.
    pub sequence: u64,
    /// The frame's time on the source's own clock, s.
    pub capture_time_s: f64,
    /// What the simulation knows.
    pub truth: FrameTruth,
}

impl RecordedTruth {
    pub(crate) fn of(message: &Truth) -> Self {
        let force_n = [message.force_x_n, message.force_y_n, message.force_z_n];
        let truth = FrameTruth { depth_mm: message.depth_mm, force_n, torque_nmm: message.torque_z_nmm };
        Self { sequence: message.sequence, capture_time_s: message.capture_time_s, truth }
    }
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
        self.attachment(sensor, PROFILE_NAME).map(Profile::from_toml).transpose()
    }

    /// The scene that a simulated sensor showed, as TOML; of several presses, that of the first.
    #[must_use]
    pub fn scene_toml(&self, sensor: usize) -> Option<&str> {
        self.attachment(sensor, SCENE_NAME)
    }

    fn attachment(&self, sensor: usize, name: &str) -> Option<&str> {
        let name = format!("{}/{name}", self.sensors.get(sensor)?.prefix);
        let attachment = self.contents.attachments.iter().find(|attachment| attachment.name == name)?;
        std::str::from_utf8(&attachment.data).ok()
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

    /// The numbers of all readings of a sensor, in order. Those of chunks whose check sum is wrong are left out.
    ///
    /// # Errors
    ///
    /// [`RecordingError::Read`] if the system refuses.
    pub fn readings(&self, sensor: usize) -> Result<Vec<ReadingNumbers>, RecordingError> {
        self.messages(sensor, Topic::Reading, |reading: Reading| numbers::from_message(&reading))
    }

    /// The truth of every frame of a simulated sensor, in order, as [`Self::readings`]; empty for a real one.
    ///
    /// # Errors
    ///
    /// [`RecordingError::Read`] if the system refuses.
    pub fn truths(&self, sensor: usize) -> Result<Vec<RecordedTruth>, RecordingError> {
        self.messages(sensor, Topic::Truth, |truth: Truth| RecordedTruth::of(&truth))
    }

    /// The events of a sensor, in order, as [`Self::readings`].
    ///
    /// # Errors
    ///
    /// [`RecordingError::Read`] if the system refuses.
    pub fn events(&self, sensor: usize) -> Result<Vec<String>, RecordingError> {
        self.messages(sensor, Topic::Log, |log: Log| log.message)
    }

    /// When each frame of a sensor was exposed, s, on its source's own clock, in order, as [`Self::readings`]. The images
    /// are not decoded.
    ///
    /// # Errors
    ///
    /// [`RecordingError::Read`] if the system refuses.
    pub fn capture_times_s(&self, sensor: usize) -> Result<Vec<f64>, RecordingError> {
        self.messages(sensor, Topic::Frame, |frame: Frame| frame.capture_time_s)
    }

    /// What is wanted of each message of a topic.
    fn messages<M: Message + Default, T>(
        &self,
        sensor: usize,
        topic: Topic,
        wanted: impl Fn(M) -> T,
    ) -> Result<Vec<T>, RecordingError> {
        let mut reader = self.reader()?;
        let mut found = Vec::new();
        for place in self.places(sensor, topic) {
            let bytes = reader.read_sound(*place).map_err(RecordingError::reading(&self.path))?;
            found.extend(bytes.and_then(|bytes| M::decode(bytes).ok()).map(&wanted));
        }
        Ok(found)
    }

    pub(crate) fn reader(&self) -> Result<MessageReader, RecordingError> {
        let file = File::open(&self.path).map_err(RecordingError::reading(&self.path))?;
        Ok(MessageReader::new(file, Arc::clone(&self.contents)))
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

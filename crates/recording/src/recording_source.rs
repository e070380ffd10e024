//! The frames of a sensor of a recording, as a source.

use std::path::Path;

use fingervision_image::Frame;
use fingervision_source::{CameraFrameDecoder, EncodedFrame, FrameFormat, FrameTruth, Source, SourceError};
use prost::Message;

use crate::container::scan::Place;
use crate::message::Truth;
use crate::message_reader::MessageReader;
use crate::topic::Topic;
use crate::{RecordedTruth, Recording, RecordingError};

/// The frames of a sensor, in order, with their original numbers and times.
pub struct RecordingSource {
    recording: Recording,
    sensor: usize,
    reader: MessageReader,
    frames: Vec<Place>,
    images: Vec<Place>,
    /// Empty for a real sensor.
    truths: Vec<Place>,
    /// That of the last frame.
    truth: Option<FrameTruth>,
    next: usize,
    /// Numbers of the first and the last frame.
    sequences: [u64; 2],
    format: FrameFormat,
    has_full_colour: bool,
    decoder: Option<CameraFrameDecoder>,
    encoded: EncodedFrame,
    is_ended: bool,
}

impl RecordingSource {
    /// The frames of a sensor.
    ///
    /// # Errors
    ///
    /// [`SourceError::TooFewFrames`] if there are fewer than two, [`SourceError::Frame`] if the first cannot be read,
    /// [`SourceError::NotFound`] and [`SourceError::Io`] if the file cannot be opened.
    pub fn open(recording: Recording, sensor: usize) -> Result<Self, SourceError> {
        let path = recording.path().to_owned();
        let mut reader = recording.reader().map_err(|error| refused(&path, error))?;
        let frames = recording.places(sensor, Topic::Frame).to_vec();
        let images = recording.places(sensor, Topic::Image).to_vec();
        let truths = recording.places(sensor, Topic::Truth).to_vec();
        let (Some(first), Some(last), 2..) = (frames.first(), frames.last(), frames.len()) else {
            return Err(SourceError::TooFewFrames { path, count: frames.len() as u64 });
        };
        let mut encoded = EncodedFrame::empty();
        let damaged = |sequence, reason| SourceError::Frame { path: path.clone(), sequence, reason };
        // The number of the last frame is known even if its bytes are damaged.
        let _ = reader.frame(*last, &images, &mut encoded);
        let last_sequence = encoded.sequence;
        reader.frame(*first, &images, &mut encoded).map_err(|reason| damaged(encoded.sequence, reason))?;
        let mut decoder = CameraFrameDecoder::for_tracking(encoded.layout);
        let pixels = decoder.decode(&encoded.bytes).map_err(|reason| damaged(encoded.sequence, reason))?;
        let sequences = [encoded.sequence, last_sequence.max(encoded.sequence)];
        let (format, decoder) = (FrameFormat::from(&pixels), Some(decoder));
        let (next, is_ended) = (0, false);
        // A sensor whose source has coarse colour is tracked, and recorded, without `flow.colour`.
        let has_full_colour = !matches!(recording.profile(sensor), Ok(Some(profile)) if !profile.flow.colour);
        Ok(Self {
            recording,
            sensor,
            reader,
            frames,
            images,
            truths,
            truth: None,
            next,
            sequences,
            format,
            has_full_colour,
            decoder,
            encoded,
            is_ended,
        })
    }

    /// Writes the original bytes of the next frame to `frame`; false after the last.
    ///
    /// # Errors
    ///
    /// [`SourceError::Frame`] if its bytes are damaged; the next call continues with the frame behind it.
    pub fn next_encoded(&mut self, frame: &mut EncodedFrame) -> Result<bool, SourceError> {
        let Some(place) = self.frames.get(self.next).copied() else { return Ok(false) };
        self.next += 1;
        self.truth = None;
        match self.reader.frame(place, &self.images, frame) {
            Ok(()) => {
                self.truth = self.read_truth(place.time_ns, frame.sequence);
                Ok(true)
            }
            Err(reason) => Err(damaged(self.recording.path(), frame.sequence, reason)),
        }
    }

    /// The truth of the frame with this number, whose message has the same time; none if it is damaged.
    fn read_truth(&mut self, time_ns: u64, sequence: u64) -> Option<FrameTruth> {
        let index = self.truths.binary_search_by_key(&time_ns, |place| place.time_ns).ok()?;
        let bytes = self.reader.read_sound(*self.truths.get(index)?).ok()??;
        let recorded = RecordedTruth::of(&Truth::decode(bytes).ok()?);
        (recorded.sequence == sequence).then_some(recorded.truth)
    }

    fn decode(&mut self) -> Result<Frame, SourceError> {
        let encoded = &self.encoded;
        let (sequence, path) = (encoded.sequence, self.recording.path());
        let mut decoder = self.decoder.take().filter(|decoder| decoder.layout() == encoded.layout);
        let in_use = decoder.get_or_insert_with(|| CameraFrameDecoder::for_tracking(encoded.layout));
        let pixels = in_use.decode(&encoded.bytes).map_err(|reason| damaged(path, sequence, reason))?;
        self.decoder = decoder;
        let (found, expected) = (FrameFormat::from(&pixels), self.format);
        if found != expected {
            return Err(SourceError::FormatChanged { path: path.to_owned(), sequence, found, expected });
        }
        Ok(Frame { sequence, capture_time_s: encoded.capture_time_s, pixels })
    }
}

impl Source for RecordingSource {
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        if self.is_ended {
            return Ok(None);
        }
        let mut encoded = std::mem::replace(&mut self.encoded, EncodedFrame::empty());
        let read = self.next_encoded(&mut encoded);
        self.encoded = encoded;
        let frame = match read {
            Ok(false) => return Ok(None),
            Ok(true) => self.decode(),
            Err(error) => Err(error),
        };
        self.is_ended = frame.is_err();
        frame.map(Some)
    }

    fn resume(&mut self) -> bool {
        self.is_ended = false;
        true
    }

    fn frame_count(&self) -> Option<u64> {
        Some(self.frames.len() as u64)
    }

    fn last_sequence(&self) -> Option<u64> {
        Some(self.sequences[1])
    }

    fn has_full_colour(&self) -> bool {
        self.has_full_colour
    }

    fn truth(&self) -> Option<FrameTruth> {
        self.truth
    }

    fn scene_toml(&self) -> Option<String> {
        self.recording.scene_toml(self.sensor).map(Into::into)
    }

    fn size(&self) -> (usize, usize) {
        (self.format.width, self.format.height)
    }

    fn description(&self) -> String {
        let (path, count) = (self.recording.path().display(), self.frames.len());
        let name = self.recording.sensors().get(self.sensor).map_or("", |sensor| &sensor.name);
        format!("recording {path}, sensor {name}: {count} frames, {}", self.format)
    }

    fn remarks(&self) -> Vec<String> {
        self.recording.remarks()
    }
}

fn damaged(path: &Path, sequence: u64, reason: String) -> SourceError {
    SourceError::Frame { path: path.to_owned(), sequence, reason }
}

/// The error if the file cannot be opened again.
fn refused(path: &Path, error: RecordingError) -> SourceError {
    let path = path.to_owned();
    match error {
        RecordingError::Read { error, .. } => SourceError::Io { path, error },
        other => SourceError::Container { path, reason: other.to_string() },
    }
}

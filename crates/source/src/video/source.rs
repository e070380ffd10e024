//! A video file: samples out of the container, through the decoder, into the order in which they are shown.
//!
//! With B-frames a sample may be shown later than its successors in the file. The container's times give the order, so
//! a decoded frame waits only until all frames that are shown before it have been delivered.

use crate::motion_jpeg::MotionJpeg;
use crate::video::decoder::Decoder;
use crate::video::fault::Fault;
use crate::video::fields::has_two_fields;
use crate::video::h264::H264;
use crate::video::numbering;
use crate::video::track::{Codec, Sample, Shown, Track};
use crate::{FrameFormat, Source, SourceError};
use fingervision_image::Frame;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// In H.264 at most this many frames wait for an earlier one.
const MAX_WAITING: usize = 16;

/// Reads the frames of a video file in presentation order.
pub(crate) struct VideoSource {
    path: PathBuf,
    file: File,
    file_len: u64,
    track: Track,
    decoder: Box<dyn Decoder>,
    /// Set by the first frame decoded.
    format: Option<FrameFormat>,
    /// The first frame, read when the file was opened.
    first: Option<Frame>,
    /// The sequence numbers still to hand out, last first.
    to_show: Vec<u64>,
    /// How many samples have been decoded.
    decoded: usize,
    /// The sequence number after that of the last frame delivered.
    shown_to: u64,
    /// Decoded frames that are shown later, by sequence number.
    waiting: BTreeMap<u64, Frame>,
    /// Comes after the frames that wait.
    failure: Option<SourceError>,
    /// The first sample behind the one that the failure is about.
    behind_failure: Option<usize>,
    /// The compressed bytes of one sample.
    sample: Vec<u8>,
}

impl VideoSource {
    /// Opens the file at `path` with the reader for its container.
    pub(crate) fn open(path: &Path, read: fn(&mut File) -> Result<Track, Fault>) -> Result<Self, SourceError> {
        let io = |error| SourceError::io(path, error);
        let mut file = File::open(path).map_err(io)?;
        let file_len = file.metadata().map_err(io)?.len();
        let mut track = read(&mut file).map_err(|fault| fault.at(path))?;
        number_by_time(&mut track.samples);
        let decoder = decoder(&track.codec).map_err(|fault| fault.at(path))?;
        let to_show = numbers_last_first(&track.samples);
        if to_show.len() < 2 {
            return Err(SourceError::TooFewFrames { path: path.to_owned(), count: to_show.len() as u64 });
        }
        let mut source = Self {
            path: path.to_owned(),
            file,
            file_len,
            track,
            decoder,
            format: None,
            first: None,
            to_show,
            decoded: 0,
            shown_to: 0,
            waiting: BTreeMap::new(),
            failure: None,
            behind_failure: None,
            sample: Vec::new(),
        };
        source.first = source.advance()?;
        // The sample last read: a file is of one kind throughout.
        if matches!(source.track.codec, Codec::MotionJpeg) && has_two_fields(&source.sample) {
            return Err(SourceError::interlaced(path));
        }
        Ok(source)
    }

    /// The next frame in presentation order.
    fn advance(&mut self) -> Result<Option<Frame>, SourceError> {
        while !self.has_next() && self.failure.is_none() {
            let Some(&sample) = self.track.samples.get(self.decoded) else { break };
            self.decoded += 1;
            if let Err(error) = self.decode(sample) {
                self.failure = Some(error);
                self.behind_failure = Some(self.decoded);
            }
        }
        if let Some((sequence, frame)) = self.waiting.pop_first() {
            while self.to_show.pop_if(|next| *next <= sequence).is_some() {}
            self.shown_to = sequence + 1;
            return Ok(Some(frame));
        }
        self.finish()
    }

    /// Ends the film: with the error that stopped it, if one did.
    fn finish(&mut self) -> Result<Option<Frame>, SourceError> {
        self.to_show.clear();
        self.decoded = self.track.samples.len();
        let is_cut_off = std::mem::take(&mut self.track.is_cut_off);
        match self.failure.take() {
            Some(error) => Err(error),
            None if is_cut_off => Err(self.fault(self.end(), "the file is cut off before it".into())),
            None => Ok(None),
        }
    }

    /// The sequence number after the last.
    fn end(&self) -> u64 {
        let sequences = self.track.samples.iter().filter_map(|sample| Some(sample.shown?.sequence + 1));
        sequences.max().unwrap_or(0)
    }

    /// Whether the frame to show next is decoded.
    fn has_next(&self) -> bool {
        self.to_show.last().is_some_and(|next| self.waiting.contains_key(next))
    }

    fn decode(&mut self, sample: Sample) -> Result<(), SourceError> {
        let sequence = sample.shown.map_or(0, |shown| shown.sequence);
        self.read(sample, sequence)?;
        let pixels = self.decoder.decode(&self.sample).map_err(|reason| self.fault(sequence, reason))?;
        let Some(Shown { sequence, time_s }) = sample.shown else { return Ok(()) };
        if sequence < self.shown_to {
            // Behind a frame that could not be decoded, damaged times may lead back: its turn is over.
            return Ok(());
        }
        let pixels = self.track.turn.apply(pixels);
        let found = FrameFormat::from(&pixels);
        let expected = *self.format.get_or_insert(found);
        if found != expected {
            return Err(SourceError::FormatChanged { path: self.path.clone(), sequence, found, expected });
        }
        if self.waiting.len() > MAX_WAITING {
            return Err(self.fault(sequence, format!("shown more than {MAX_WAITING} frames after it is decoded")));
        }
        self.waiting.insert(sequence, Frame { sequence, capture_time_s: time_s, pixels });
        Ok(())
    }

    /// Reads the compressed bytes of a sample.
    fn read(&mut self, sample: Sample, sequence: u64) -> Result<(), SourceError> {
        let end = sample.offset.saturating_add(u64::from(sample.len));
        if end > self.file_len {
            return Err(self.fault(sequence, "the file is cut off within it".into()));
        }
        self.sample.resize(sample.len as usize, 0);
        let read = self.file.seek(SeekFrom::Start(sample.offset)).and_then(|_| self.file.read_exact(&mut self.sample));
        read.map_err(|error| SourceError::io(&self.path, error))
    }

    /// The first sample from this one on that needs none before it; one that cannot be read counts, to be named.
    fn next_key(&mut self, from: usize) -> usize {
        let count = self.track.samples.len();
        let mut is_start = |index: usize| {
            let is_read = self.read(self.track.samples[index], 0).is_ok();
            !is_read || self.decoder.is_key(&self.sample)
        };
        (from..count).find(|&index| is_start(index)).unwrap_or(count)
    }

    fn shown_count(&self) -> u64 {
        self.track.samples.iter().filter(|sample| sample.shown.is_some()).count() as u64
    }

    fn fault(&self, sequence: u64, reason: String) -> SourceError {
        SourceError::Frame { path: self.path.clone(), sequence, reason }
    }
}

/// Leaves a gap in the sequence numbers where the times of the film jump.
fn number_by_time(samples: &mut [Sample]) {
    let mut shown: Vec<&mut Shown> = samples.iter_mut().filter_map(|sample| sample.shown.as_mut()).collect();
    shown.sort_by_key(|shown| shown.sequence);
    let times_s: Vec<f64> = shown.iter().map(|shown| shown.time_s).collect();
    for (shown, number) in shown.iter_mut().zip(numbering::by_times(&times_s)) {
        shown.sequence = number;
    }
}

impl Source for VideoSource {
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        match self.first.take() {
            Some(first) => Ok(Some(first)),
            None => self.advance(),
        }
    }

    fn resume(&mut self) -> bool {
        let Some(behind) = self.behind_failure.take() else { return false };
        // The old one may be in an unknown state. A new one was made of the same parameters before.
        let Ok(decoder) = decoder(&self.track.codec) else { return false };
        self.decoder = decoder;
        self.decoded = self.next_key(behind);
        self.to_show = numbers_last_first(&self.track.samples[self.decoded..]);
        true
    }

    fn frame_count(&self) -> Option<u64> {
        Some(self.shown_count())
    }

    fn last_sequence(&self) -> Option<u64> {
        self.end().checked_sub(1)
    }

    fn size(&self) -> (usize, usize) {
        self.format.map_or((0, 0), |format| (format.width, format.height))
    }

    /// Videos store colour at half the resolution or coarsely, with few exceptions.
    fn has_full_colour(&self) -> bool {
        false
    }

    fn description(&self) -> String {
        let codec = match self.track.codec {
            Codec::H264 { .. } => "H.264",
            Codec::MotionJpeg => "motion JPEG",
        };
        let format = self.format.map(|format| format.to_string()).unwrap_or_default();
        format!("{}: {codec} video, {} frames, {format}", self.path.display(), self.shown_count())
    }
}

/// A decoder at the start of a film.
fn decoder(codec: &Codec) -> Result<Box<dyn Decoder>, Fault> {
    Ok(match codec {
        Codec::H264 { config, colour } => Box::new(H264::new(config, *colour)?),
        Codec::MotionJpeg => Box::new(MotionJpeg::default()),
    })
}

/// The sequence numbers of samples that are shown, last first.
fn numbers_last_first(samples: &[Sample]) -> Vec<u64> {
    let mut numbers: Vec<u64> = samples.iter().filter_map(|sample| Some(sample.shown?.sequence)).collect();
    numbers.sort_unstable_by(|a, b| b.cmp(a));
    numbers
}

//! Writes pictures as H.264 into a fragmented MP4 file.
//!
//! The description of the track comes first, then fragments of up to a second, each of which begins with a keyframe and
//! needs nothing that comes later (ISO/IEC 14496-12:2015, 8.8). What was written is never changed: a run that is killed
//! leaves a video up to its last fragment. Pictures have their own times.

mod boxes;
mod planes;

use std::fmt;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use fingervision_image::Image;
use fingervision_plot::Rgb;
use rusty_h264_common::nal::split_annex_b;
use rusty_h264_common::types::YuvPlanes;
use rusty_h264_encoder::{Encoder, EncoderConfig};

use crate::SinkError;
use boxes::{Fragment, Sample, TICKS_PER_SECOND, Track};
use planes::Planes;

/// Pictures of a fragment.
const FRAGMENT_LEN: u32 = 30;
/// The quantiser, 0 to 51: small text stays sharp.
const QUANTISER: u8 = 22;
/// Level 4.2 of the standard, ten times: up to 2048×1088 px at 60 frames per second.
const LEVEL: u8 = 42;
/// Duration of the last picture if there is only one.
const USUAL_TICKS: u32 = TICKS_PER_SECOND / 30;
/// The longest time for which a picture is shown, s.
const LONGEST_S: f64 = 3600.0;
/// Kinds of a NAL unit.
const KEYFRAME: u8 = 5;
const SEQUENCE_PARAMETERS: u8 = 7;
const PICTURE_PARAMETERS: u8 = 8;

/// A video that grows fragment by fragment.
pub(crate) struct Mp4Writer<W = File> {
    path: PathBuf,
    to: W,
    encoder: Encoder,
    planes: Planes,
    /// The fragment that is not written yet; its last picture has no duration until the next one comes.
    fragment: Fragment,
    has_track: bool,
    /// Time of the last picture, ticks.
    last_ticks: u64,
}

impl<W> fmt::Debug for Mp4Writer<W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Mp4Writer").field("path", &self.path).finish_non_exhaustive()
    }
}

impl Mp4Writer {
    /// Creates a file, or empties it, for pictures of this size in px, which is even.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the file cannot be written or the size cannot be encoded.
    pub(crate) fn create(path: &Path, size: (usize, usize)) -> Result<Self, SinkError> {
        let file = File::create(path).map_err(SinkError::writing(path))?;
        Self::new(file, path, size)
    }

    /// Writes the last fragment and flushes everything to the disk.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the disk refuses it.
    pub(crate) fn finish(mut self) -> Result<(), SinkError> {
        self.close()?;
        self.to.sync_all().map_err(SinkError::writing(&self.path))
    }
}

impl<W: Write> Mp4Writer<W> {
    fn new(to: W, path: &Path, (width, height): (usize, usize)) -> Result<Self, SinkError> {
        // Constrained Baseline, which every player decodes: a picture is coded when it comes.
        let mut config = EncoderConfig::baseline(width, height);
        (config.gop_size, config.min_keyint) = (FRAGMENT_LEN, FRAGMENT_LEN);
        (config.qp, config.level_idc) = (QUANTISER, LEVEL);
        let encoder = Encoder::new(config).map_err(|error| SinkError::writing(path)(io::Error::other(error)))?;
        let planes = Planes::new(width, height);
        let path = path.to_path_buf();
        Ok(Self { path, to, encoder, planes, fragment: Fragment::default(), has_track: false, last_ticks: 0 })
    }

    /// Appends a picture that is shown from this time on, s since the first one.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the file cannot take it; the video then ends with the previous fragment.
    pub(crate) fn write(&mut self, picture: &Image<Rgb>, time_s: f64) -> Result<(), SinkError> {
        self.append(picture, time_s).map_err(SinkError::writing(&self.path))
    }

    fn append(&mut self, picture: &Image<Rgb>, time_s: f64) -> io::Result<()> {
        self.planes.load(picture);
        let Planes { width, height, luma, blue, red } = &self.planes;
        let planes = YuvPlanes::tight(*width, *height, luma, blue, red);
        let coded = planes.map(|planes| self.encoder.encode_planes(&planes));
        let coded = coded.ok_or_else(|| io::Error::other("the size is odd"))?.map_err(io::Error::other)?;
        let ticks = self.ticks(time_s);
        self.fragment.end_last((ticks - self.last_ticks) as u32);
        self.last_ticks = ticks;
        let units = split_annex_b(&coded);
        let is_key = units.iter().any(|unit| kind(unit) == KEYFRAME);
        if is_key {
            self.begin_fragment(&units, ticks)?;
        }
        let start = self.fragment.data.len();
        for unit in units.iter().filter(|unit| !matches!(kind(unit), SEQUENCE_PARAMETERS | PICTURE_PARAMETERS)) {
            self.fragment.data.extend((unit.len() as u32).to_be_bytes());
            self.fragment.data.extend_from_slice(unit);
        }
        let len = (self.fragment.data.len() - start) as u32;
        self.fragment.samples.push(Sample { len, ticks: USUAL_TICKS, is_key });
        Ok(())
    }

    /// When a picture is shown: the first one at 0. A time that is not later than the last one, or later by more than an
    /// hour, is replaced: the picture then follows at the usual rate.
    fn ticks(&self, time_s: f64) -> u64 {
        if !self.has_track {
            return 0;
        }
        let last_s = self.last_ticks as f64 / f64::from(TICKS_PER_SECOND);
        let ticks = (time_s * f64::from(TICKS_PER_SECOND)).round() as u64;
        let is_usual = time_s.is_finite() && time_s < last_s + LONGEST_S && ticks > self.last_ticks;
        if is_usual { ticks } else { self.last_ticks + u64::from(USUAL_TICKS) }
    }

    /// Writes what comes before a keyframe.
    fn begin_fragment(&mut self, units: &[&[u8]], ticks: u64) -> io::Result<()> {
        if !self.has_track {
            let of_kind = |wanted| units.iter().find(|unit| kind(unit) == wanted).copied();
            let parameters = of_kind(SEQUENCE_PARAMETERS).zip(of_kind(PICTURE_PARAMETERS));
            let (sequence, picture) =
                parameters.ok_or_else(|| io::Error::other("the encoder described no sequence"))?;
            let track = Track { size: (self.planes.width, self.planes.height), sequence, picture };
            self.to.write_all(&track.bytes())?;
            self.has_track = true;
        }
        self.write_fragment()?;
        self.fragment.start_ticks = ticks;
        Ok(())
    }

    fn write_fragment(&mut self) -> io::Result<()> {
        if !self.fragment.samples.is_empty() {
            self.fragment.number += 1;
            self.to.write_all(&self.fragment.header())?;
            self.to.write_all(&self.fragment.data)?;
            self.fragment.data.clear();
            self.fragment.samples.clear();
        }
        Ok(())
    }

    fn close(&mut self) -> Result<(), SinkError> {
        // The last picture is shown as long as the one before it.
        if let [.., before, last] = self.fragment.samples.as_mut_slice() {
            last.ticks = before.ticks;
        }
        self.write_fragment().map_err(SinkError::writing(&self.path))
    }
}

fn kind(unit: &[u8]) -> u8 {
    unit.first().map_or(0, |header| header & 0x1f)
}

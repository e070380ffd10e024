//! AVI files: which chunks are the frames of the video.
//!
//! A RIFF file is a sequence of chunks, each four letters, a length and its content; lists are chunks whose content is
//! again a sequence. Only leaves are needed here, so lists are entered and the file is read as one flat sequence. That
//! covers the later parts of files beyond 1 GiB (`AVIX`) and needs no index, so that a recording that was never closed
//! can be read up to its end.
//!
//! Only motion JPEG is read. An empty chunk represents a frame that the recorder dropped: its number is skipped.

use crate::video::fault::Fault;
use crate::video::track::{Codec, Sample, Shown, Track, Turn};
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};

/// Length of a chunk's four letters and its size, bytes.
const HEADER_LEN: u64 = 8;
/// Bytes of `strh` and `strf` that are read.
const STREAM_HEADER_LEN: usize = 28;
/// Names of motion JPEG.
const MOTION_JPEG: [&[u8; 4]; 5] = [b"MJPG", b"mjpg", b"JPEG", b"jpeg", b"dmb1"];

/// Reads the video track of an AVI file.
pub(crate) fn read_track(file: &mut File) -> Result<Track, Fault> {
    let file_len = file.metadata()?.len();
    let mut walk = Walk { reader: BufReader::new(file), at: 0, file_len, frames_end: 0 };
    let mut streams = Streams::default();
    let mut chunks = Vec::new();
    while let Some(chunk) = walk.next_chunk()? {
        match &chunk.kind {
            b"LIST" | b"RIFF" => walk.enter(&chunk)?,
            b"strh" => streams.add(walk.head(&chunk)?),
            b"strf" => streams.set_format(walk.head(&chunk)?),
            &[a, b, b'd', b'c' | b'b'] if streams.video_number() == Some([a, b]) => chunks.push(chunk),
            _ => {}
        }
        walk.skip(&chunk);
    }
    // A file that ends within its frames, or whose chunks are inconsistent, must not pass for a shorter film.
    let is_cut_off = walk.frames_end > walk.at.min(file_len);
    let video = streams.video.ok_or(Fault::NotRead("an AVI file without video".into()))?;
    if !MOTION_JPEG.contains(&&video.codec) {
        return Err(Fault::NotRead(format!("{} video in AVI", video.codec.escape_ascii())));
    }
    let samples = samples(&chunks, video.frame_period_s()?);
    Ok(Track { codec: Codec::MotionJpeg, samples, turn: Turn::None, is_cut_off })
}

fn samples(chunks: &[Chunk], frame_period_s: f64) -> Vec<Sample> {
    let numbered = (0..).zip(chunks).filter(|(_, chunk)| chunk.len > 0);
    let sample = |(sequence, chunk): (u64, &Chunk)| {
        let shown = Shown { sequence, time_s: sequence as f64 * frame_period_s };
        Sample { offset: chunk.content, len: chunk.len, shown: Some(shown) }
    };
    numbered.map(sample).collect()
}

/// One chunk's letters and place.
#[derive(Clone, Copy)]
struct Chunk {
    kind: [u8; 4],
    /// Where the content starts, bytes.
    content: u64,
    /// Length of the content, bytes.
    len: u32,
}

/// A walk from chunk to chunk.
struct Walk<R> {
    reader: R,
    /// Where the next chunk starts, bytes.
    at: u64,
    file_len: u64,
    /// End of the last list of frames by its own header, bytes.
    frames_end: u64,
}

impl<R: Read + Seek> Walk<BufReader<R>> {
    fn next_chunk(&mut self) -> Result<Option<Chunk>, Fault> {
        if self.at + HEADER_LEN > self.file_len {
            return Ok(None);
        }
        let [a, b, c, d, len @ ..] = self.read_array::<8>(self.at)?;
        let kind = [a, b, c, d];
        // A recorder that was killed leaves zeros after the last chunk.
        let is_chunk = kind.iter().all(|letter| (b' '..=b'~').contains(letter));
        Ok(is_chunk.then_some(Chunk { kind, content: self.at + HEADER_LEN, len: u32::from_le_bytes(len) }))
    }

    /// Stores where a list of frames ends.
    fn enter(&mut self, list: &Chunk) -> Result<(), Fault> {
        if list.content + 4 <= self.file_len && self.read_array(list.content)? == *b"movi" {
            self.frames_end = list.content + u64::from(list.len);
        }
        Ok(())
    }

    /// Moves on: past the name of a list, past the content of everything else.
    fn skip(&mut self, chunk: &Chunk) {
        let is_list = matches!(&chunk.kind, b"LIST" | b"RIFF");
        let len = u64::from(chunk.len);
        self.at = chunk.content + if is_list { 4 } else { len + len % 2 };
    }

    /// The first bytes of a chunk's content, zeros where it ends before.
    fn head(&mut self, chunk: &Chunk) -> Result<[u8; STREAM_HEADER_LEN], Fault> {
        let mut head = [0; STREAM_HEADER_LEN];
        let len = u64::from(chunk.len).min(self.file_len.saturating_sub(chunk.content)).min(STREAM_HEADER_LEN as u64);
        self.seek(chunk.content)?;
        self.reader.read_exact(&mut head[..len as usize])?;
        Ok(head)
    }

    fn read_array<const N: usize>(&mut self, at: u64) -> Result<[u8; N], Fault> {
        let mut bytes = [0; N];
        self.seek(at)?;
        self.reader.read_exact(&mut bytes)?;
        Ok(bytes)
    }

    fn seek(&mut self, at: u64) -> Result<(), Fault> {
        let now = self.reader.stream_position()?;
        // Keeps the buffer if it contains the place; plain seeking would read the file again for every chunk.
        match i64::try_from(at).ok().zip(i64::try_from(now).ok()) {
            Some((at, now)) => self.reader.seek_relative(at - now)?,
            None => drop(self.reader.seek(SeekFrom::Start(at))?),
        }
        Ok(())
    }
}

/// The streams declared so far.
#[derive(Default)]
struct Streams {
    count: u8,
    /// The first video stream.
    video: Option<VideoStream>,
}

struct VideoStream {
    number: u8,
    /// Seconds per `rate` frames.
    scale: u32,
    rate: u32,
    codec: [u8; 4],
}

impl Streams {
    fn add(&mut self, header: [u8; STREAM_HEADER_LEN]) {
        if self.video.is_none() && header.starts_with(b"vids") {
            let (scale, rate) = (word(&header, 20), word(&header, 24));
            self.video = Some(VideoStream { number: self.count, scale, rate, codec: [0; 4] });
        }
        self.count = self.count.saturating_add(1);
    }

    /// The format follows the header of its stream.
    fn set_format(&mut self, format: [u8; STREAM_HEADER_LEN]) {
        let current = self.count.saturating_sub(1);
        if let Some(video) = self.video.as_mut().filter(|video| video.number == current) {
            video.codec = word(&format, 16).to_le_bytes();
        }
    }

    /// The two digits at the start of the name of every frame's chunk.
    fn video_number(&self) -> Option<[u8; 2]> {
        let number = self.video.as_ref()?.number;
        Some([b'0' + number / 10 % 10, b'0' + number % 10])
    }
}

impl VideoStream {
    fn frame_period_s(&self) -> Result<f64, Fault> {
        if self.scale == 0 || self.rate == 0 {
            return Err(Fault::Damaged("the AVI header gives no frame rate"));
        }
        Ok(f64::from(self.scale) / f64::from(self.rate))
    }
}

fn word(bytes: &[u8; STREAM_HEADER_LEN], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

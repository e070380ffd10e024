//! The file's outermost boxes, and the description of its video track.

use super::boxes::{Bytes, Kind, boxes, find, find_path};
use super::codec::codec;
use super::edits::Edit;
use super::fragments::add_fragment;
use super::samples::{MediaSample, sample_table};
use crate::video::fault::Fault;
use crate::video::track::{Sample, Shown, Track, Turn};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};

/// Reads the first video track of an MP4 or MOV file.
pub(crate) fn read_track(file: &mut File) -> Result<Track, Fault> {
    let index = read_index(file)?;
    let movie = index.movie.ok_or(Fault::Damaged("the file has no index (moov box): it was not closed"))?;
    let tracks = boxes(&movie).filter(|(kind, _)| kind == b"trak").map(|(_, content)| content);
    let video = { tracks }.find(|track| is_video(track)).ok_or(Fault::NotRead("an MP4 file without video".into()))?;
    let header = Header::read(&movie, video)?;
    let table = find_path(video, &[*b"mdia", *b"minf", *b"stbl"]).ok_or(NO_TABLE)?;
    let codec = codec(find(table, *b"stsd").ok_or(NO_TABLE)?)?;
    let mut samples = sample_table(table, index.file_len)?;
    for (at, fragment) in &index.fragments {
        add_fragment(&mut samples, &movie, header.track_id, *at, fragment, index.file_len)?;
    }
    let edit = Edit::read(video)?;
    let samples = in_film(&samples, |time| edit.film_time_s(time, header.timescale, header.movie_timescale));
    Ok(Track { codec, samples, turn: header.turn, is_cut_off: index.is_cut_off })
}

const NO_TABLE: Fault = Fault::Damaged("the video track has no sample table");

/// The parts of the file that locate its frames.
struct Index {
    file_len: u64,
    movie: Option<Vec<u8>>,
    /// Movie fragments with their places in the file, bytes.
    fragments: Vec<(u64, Vec<u8>)>,
    /// The file ends within a part of the index.
    is_cut_off: bool,
}

fn read_index(file: &mut File) -> Result<Index, Fault> {
    let file_len = file.metadata()?.len();
    let mut index = Index { file_len, movie: None, fragments: Vec::new(), is_cut_off: false };
    let mut at = 0;
    while at < file_len {
        let mut header = [0; 16];
        let header_len = (file_len - at).min(16) as usize;
        file.seek(SeekFrom::Start(at))?;
        file.read_exact(&mut header[..header_len])?;
        let Some((kind, content, end)) = place(&header, at, file_len) else {
            // After the index of a plain file there is at most padding; after a fragment, the next is expected.
            index.is_cut_off = !index.fragments.is_empty();
            break;
        };
        if matches!(&kind, b"moov" | b"moof") {
            if end > file_len {
                index.is_cut_off = true;
                break;
            }
            let mut bytes = vec![0; (end - content) as usize];
            file.seek(SeekFrom::Start(content))?;
            file.read_exact(&mut bytes)?;
            match &kind {
                b"moov" => index.movie = Some(bytes),
                _ => index.fragments.push((at, bytes)),
            }
        }
        at = end;
    }
    Ok(index)
}

/// Kind, start of the content and end of the box whose header is at `at`.
fn place(header: &[u8; 16], at: u64, file_len: u64) -> Option<(Kind, u64, u64)> {
    let mut bytes = Bytes(header);
    let (len, kind) = (bytes.u32()?, bytes.kind()?);
    let (header_len, len) = match len {
        0 => (8, file_len - at),
        1 => (16, bytes.u64()?),
        len => (8, u64::from(len)),
    };
    (at + header_len <= file_len && len >= header_len).then_some((kind, at + header_len, at.checked_add(len)?))
}

fn is_video(track: &[u8]) -> bool {
    let handler = find_path(track, &[*b"mdia", *b"hdlr"]);
    handler.and_then(|handler| handler.get(8..12)) == Some(b"vide")
}

/// The content of the headers of movie and track.
struct Header {
    track_id: u32,
    /// Ticks per second of the track's media.
    timescale: u32,
    /// Ticks per second of the movie.
    movie_timescale: u32,
    turn: Turn,
}

impl Header {
    fn read(movie: &[u8], track: &[u8]) -> Result<Self, Fault> {
        const DAMAGED: Fault = Fault::Damaged("the headers of the video track are damaged");
        let timescale = |header: &[u8]| {
            let mut header = Bytes(header);
            let (version, _) = header.version_and_flags()?;
            header.take(if version == 1 { 16 } else { 8 })?;
            header.u32().filter(|&timescale| timescale > 0)
        };
        let movie_timescale = find(movie, *b"mvhd").and_then(timescale).ok_or(DAMAGED)?;
        let media_timescale = find_path(track, &[*b"mdia", *b"mdhd"]).and_then(timescale).ok_or(DAMAGED)?;
        let (track_id, matrix) = find(track, *b"tkhd").and_then(track_header).ok_or(DAMAGED)?;
        Ok(Self { track_id, timescale: media_timescale, movie_timescale, turn: Turn::from_matrix(matrix)? })
    }
}

/// The track's number and the four entries of its matrix for rotation and mirroring.
fn track_header(header: &[u8]) -> Option<(u32, [i32; 4])> {
    let mut header = Bytes(header);
    let (version, _) = header.version_and_flags()?;
    // Before the number: times of creation and change. Behind it: duration, layer, group, volume.
    header.take(if version == 1 { 16 } else { 8 })?;
    let track_id = header.u32()?;
    header.take(if version == 1 { 28 } else { 24 })?;
    let [a, b, _, c, d] = [header.i32()?, header.i32()?, header.i32()?, header.i32()?, header.i32()?];
    Some((track_id, [a, b, c, d]))
}

/// Assigns a number and a time in the film to every sample; `film_time_s` converts the media's ticks to time.
fn in_film(samples: &[MediaSample], film_time_s: impl Fn(i64) -> Option<f64>) -> Vec<Sample> {
    let mut times: Vec<(usize, f64)> = Vec::new();
    for (index, sample) in samples.iter().enumerate() {
        times.extend(film_time_s(sample.time).map(|time_s| (index, time_s)));
    }
    times.sort_by(|(_, a), (_, b)| a.total_cmp(b));
    let place = |sample: &MediaSample| Sample { offset: sample.offset, len: sample.len, shown: None };
    let mut placed: Vec<Sample> = samples.iter().map(place).collect();
    for (sequence, (index, time_s)) in (0..).zip(times) {
        placed[index].shown = Some(Shown { sequence, time_s });
    }
    placed
}

//! Writes motion JPEG into an AVI file that can be played at any moment.
//!
//! The headers are rewritten after each frame, data first, so that a run that is killed leaves a video up to its last
//! frame; it then only lacks the index for seeking. Files beyond 1 GiB continue in further parts, each with its own index
//! (`OpenDML` 1.02, "AVI file format extensions"), so neither length nor memory is bounded by the format: only the index
//! of one part is kept in memory, 8 bytes per frame.
//!
//! Implemented here because it is a page of headers. It needs no encoder but that of JPEG, so every program can write it.

mod header;

use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use crate::SinkError;
use header::{HEADER_LEN, Header, IndexPart, MOST_PARTS, chunk};

/// A part is closed once its frames have this length, bytes.
const PART_LEN: u64 = 1 << 30;
/// A part's `RIFF`, its name, and the `LIST` of frames with its name, bytes.
const PART_HEADER_LEN: u64 = 24;
/// Frames are JPEG pictures of the first stream.
const FRAME: [u8; 4] = *b"00dc";
/// Every frame is a keyframe.
const KEY_FRAME: u32 = 0x10;

/// A video that grows frame by frame.
#[derive(Debug)]
pub(crate) struct AviWriter<W = File> {
    path: PathBuf,
    to: W,
    header: Header,
    part_len: u64,
    /// Where the next chunk starts, bytes.
    end: u64,
    /// Where this part's `RIFF` starts and where its list of frames starts, bytes.
    part: u64,
    list: u64,
    /// Place and length of the frames in this part: of the JPEG, from [`AviWriter::list`].
    frames: Vec<(u32, u32)>,
}

impl AviWriter {
    /// Creates a file, or empties it, for frames of this size in px.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the file cannot be written.
    pub(crate) fn create(path: &Path, size: (usize, usize)) -> Result<Self, SinkError> {
        let file = File::create(path).map_err(SinkError::writing(path))?;
        Self::new(file, path, size, PART_LEN)
    }

    /// Writes the index and flushes everything to the disk.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the disk refuses it.
    pub(crate) fn finish(mut self) -> Result<(), SinkError> {
        self.close()?;
        self.to.sync_all().map_err(SinkError::writing(&self.path))
    }
}

impl<W: Write + Seek> AviWriter<W> {
    fn new(to: W, path: &Path, size: (usize, usize), part_len: u64) -> Result<Self, SinkError> {
        let list = HEADER_LEN as u64 + 8;
        let path = path.to_path_buf();
        let header = Header::new(size);
        let mut writer = Self { path, to, header, part_len, end: list + 4, part: 0, list, frames: Vec::new() };
        let begun = writer.write_at(0, b"RIFF").and_then(|()| writer.commit());
        begun.map_err(SinkError::writing(&writer.path))?;
        Ok(writer)
    }

    /// Appends a picture; all are shown for `period_s`, the mean so far.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the file cannot take it; the video then ends with the previous frame.
    pub(crate) fn write(&mut self, jpeg: &[u8], period_s: f64) -> Result<(), SinkError> {
        self.append(jpeg, period_s).map_err(SinkError::writing(&self.path))
    }

    fn append(&mut self, jpeg: &[u8], period_s: f64) -> io::Result<()> {
        if self.end - self.list > self.part_len {
            self.close_part()?;
            self.begin_part()?;
        }
        let place = (self.end + 8 - self.list) as u32;
        self.write_chunk(FRAME, jpeg)?;
        self.frames.push((place, jpeg.len() as u32));
        self.header.count(jpeg.len(), period_s, self.part == 0);
        self.commit()
    }

    /// Updates the counts of written frames.
    fn commit(&mut self) -> io::Result<()> {
        let header = self.header.bytes();
        self.write_at(8, &header)?;
        self.write_part_header(self.end)
    }

    /// Lengths of the part and of its list of frames, which ends at `list_end`; the part ends where the file does.
    fn write_part_header(&mut self, list_end: u64) -> io::Result<()> {
        let (riff_len, list_len) = ((self.end - self.part - 8) as u32, (list_end - self.list) as u32);
        self.write_at(self.part + 4, &riff_len.to_le_bytes())?;
        let list = [b"LIST".as_slice(), &list_len.to_le_bytes(), b"movi"].concat();
        self.write_at(self.list - 8, &list)
    }

    fn begin_part(&mut self) -> io::Result<()> {
        (self.part, self.list) = (self.end, self.end + PART_HEADER_LEN - 4);
        self.write_at(self.part, b"RIFF\0\0\0\0AVIX")?;
        self.end = self.list + 4;
        self.write_part_header(self.end)
    }

    /// Writes a part's index into it, and after the first part the index that older players need.
    fn close_part(&mut self) -> io::Result<()> {
        let frames = std::mem::take(&mut self.frames);
        if self.header.parts.len() < MOST_PARTS && !frames.is_empty() {
            let index = header::part_index(self.list, &frames);
            let (at, len) = (self.end, index.len() as u32 + 8);
            self.write_chunk(*b"ix00", &index)?;
            self.header.parts.push(IndexPart { at, len, frames: frames.len() as u32 });
        }
        let list_end = self.end;
        if self.part == 0 {
            let entry = |(place, len): (u32, u32)| [u32::from_le_bytes(FRAME), KEY_FRAME, place - 8, len];
            let index: Vec<u8> = frames.into_iter().flat_map(entry).flat_map(u32::to_le_bytes).collect();
            self.write_chunk(*b"idx1", &index)?;
            self.header.has_index = true;
        }
        let header = self.header.bytes();
        self.write_at(8, &header)?;
        self.write_part_header(list_end)
    }

    fn close(&mut self) -> Result<(), SinkError> {
        self.close_part().map_err(SinkError::writing(&self.path))
    }

    fn write_chunk(&mut self, kind: [u8; 4], content: &[u8]) -> io::Result<()> {
        let bytes = chunk(kind, content);
        self.write_at(self.end, &bytes)?;
        self.end += bytes.len() as u64;
        Ok(())
    }

    fn write_at(&mut self, at: u64, bytes: &[u8]) -> io::Result<()> {
        self.to.seek(SeekFrom::Start(at))?;
        self.to.write_all(bytes)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    fn written(frames: usize, part_len: u64, is_closed: bool) -> Vec<u8> {
        let mut writer = AviWriter::new(Cursor::new(Vec::new()), Path::new("x.avi"), (16, 8), part_len).unwrap();
        for frame in 0..frames {
            // Odd and even lengths: chunks are padded.
            writer.write(&vec![frame as u8; 100 + frame], 0.02).unwrap();
        }
        if is_closed {
            writer.close().unwrap();
        }
        writer.to.into_inner()
    }

    fn word(bytes: &[u8], at: usize) -> usize {
        u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize
    }

    /// The chunks between two places: letters and content.
    fn chunks(bytes: &[u8], mut at: usize, end: usize) -> Vec<([u8; 4], usize, usize)> {
        let mut found = Vec::new();
        while at < end {
            let len = word(bytes, at + 4);
            found.push((bytes[at..at + 4].try_into().unwrap(), at + 8, len));
            at += 8 + len + len % 2;
        }
        assert_eq!(at, end, "chunks fill what holds them");
        found
    }

    #[test]
    fn chunks_fill_the_file_whether_it_was_closed_or_not() {
        for is_closed in [false, true] {
            let file = written(5, PART_LEN, is_closed);
            let parts = chunks(&file, 0, file.len());
            assert_eq!(parts.len(), 1);
            let inside = chunks(&file, 12, file.len());
            let (_, frames, len) = inside[1];
            let frames: Vec<_> =
                chunks(&file, frames + 4, frames + len).into_iter().filter(|(kind, ..)| *kind == FRAME).collect();
            assert_eq!(frames.len(), 5);
            for (number, (_, at, len)) in frames.into_iter().enumerate() {
                assert_eq!(file[at..at + len], vec![number as u8; 100 + number]);
            }
            assert_eq!(word(&file, 48), 5, "frames in the main header");
        }
    }

    #[test]
    fn both_indexes_of_a_long_video_lead_to_every_frame() {
        let file = written(7, 300, true);
        let parts = chunks(&file, 0, file.len());
        assert!(parts.len() > 2, "{parts:?}");
        let super_index = file.windows(4).position(|letters| letters == b"indx").unwrap() + 8;
        assert_eq!(word(&file, super_index + 4), parts.len());
        let mut found = Vec::new();
        for part in 0..parts.len() {
            let at = word(&file, super_index + 24 + 16 * part);
            assert_eq!(file[at..at + 4], *b"ix00");
            let base = word(&file, at + 20);
            for entry in 0..word(&file, at + 12) {
                let (place, len) = (word(&file, at + 32 + 8 * entry), word(&file, at + 36 + 8 * entry));
                found.push(file[base + place..base + place + len].to_vec());
            }
        }
        let expected: Vec<Vec<u8>> = (0..7).map(|frame| vec![frame as u8; 100 + frame]).collect();
        assert_eq!(found, expected);

        let old = file.windows(4).position(|letters| letters == b"idx1").unwrap();
        let movi = file.windows(4).position(|letters| letters == b"movi").unwrap();
        assert_eq!(file[movi + word(&file, old + 16)..][..4], FRAME, "places count from the list's name");
    }
}

//! Streams frames into a `.npy` file that can be read at any moment.
//!
//! The number of frames is in the header and is not known in advance. The header has a fixed length of 128 bytes and is
//! rewritten after each frame, data first: a run that is killed or fills the disk leaves a file that contains every frame
//! its header counts. Bytes of an unfinished frame may follow; readers take as many values as the header says. Nothing is
//! forced onto the disk before [`ArrayWriter::finish`], so a power cut may cost more than the last frame.
//!
//! Format: version 1.0 of the `.npy` format. Our own writer, because `npyz` needs the whole shape before the first value
//! and writes the header once.

use std::fs::File;
use std::io::{Seek, SeekFrom, Write};
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

use half::f16;

use crate::SinkError;

/// Bytes of the whole header, a multiple of 64 as the format asks.
const HEADER_LEN: usize = 128;
/// Magic string, format version 1.0 and the length of what follows.
const PREAMBLE: [u8; 10] = [0x93, b'N', b'U', b'M', b'P', b'Y', 1, 0, (HEADER_LEN - 10) as u8, 0];

/// The type of one pixel of an array.
pub trait Element: Copy {
    /// The format's name of the scalar type.
    const DESCR: &'static str;
    /// Lengths of the dimensions after columns.
    const CHANNELS: &'static [usize];
    /// Bytes of a pixel.
    const LEN: usize;

    /// Writes the pixel, little endian, into its [`Element::LEN`] bytes.
    fn put(self, bytes: &mut [u8]);
}

impl Element for u8 {
    const DESCR: &'static str = "|u1";
    const CHANNELS: &'static [usize] = &[];
    const LEN: usize = 1;

    fn put(self, bytes: &mut [u8]) {
        bytes[0] = self;
    }
}

impl Element for f32 {
    const DESCR: &'static str = "<f4";
    const CHANNELS: &'static [usize] = &[];
    const LEN: usize = 4;

    fn put(self, bytes: &mut [u8]) {
        bytes.copy_from_slice(&self.to_le_bytes());
    }
}

impl Element for f16 {
    const DESCR: &'static str = "<f2";
    const CHANNELS: &'static [usize] = &[];
    const LEN: usize = 2;

    fn put(self, bytes: &mut [u8]) {
        bytes.copy_from_slice(&self.to_le_bytes());
    }
}

impl<const N: usize, T: Element> Element for [T; N] {
    const DESCR: &'static str = T::DESCR;
    const CHANNELS: &'static [usize] = &[N];
    const LEN: usize = N * T::LEN;

    fn put(self, bytes: &mut [u8]) {
        for (value, bytes) in self.into_iter().zip(bytes.chunks_exact_mut(T::LEN)) {
            value.put(bytes);
        }
    }
}

/// A growing array `[frame][row][column]` of elements in a file.
#[derive(Debug)]
pub struct ArrayWriter<T, W = File> {
    path: PathBuf,
    to: W,
    width: usize,
    height: usize,
    frames: u64,
    bytes: Vec<u8>,
    element: PhantomData<T>,
}

impl<T: Element> ArrayWriter<T> {
    /// Creates a file, or empties it, for frames of this size in px.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the file cannot be written.
    pub fn create(path: &Path, width: usize, height: usize) -> Result<Self, SinkError> {
        let file = File::create(path).map_err(SinkError::writing(path))?;
        Self::new(file, path, width, height)
    }

    /// Flushes everything to the disk.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the disk refuses it.
    pub fn finish(self) -> Result<(), SinkError> {
        self.to.sync_all().map_err(SinkError::writing(&self.path))
    }
}

impl<T: Element, W: Write + Seek> ArrayWriter<T, W> {
    fn new(to: W, path: &Path, width: usize, height: usize) -> Result<Self, SinkError> {
        let bytes = vec![0; width * height * T::LEN];
        let path = path.to_path_buf();
        let mut writer = Self { path, to, width, height, frames: 0, bytes, element: PhantomData };
        writer.write_header()?;
        Ok(writer)
    }

    /// Appends one frame and counts it.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the file cannot take it; the frame is then not counted and the next one takes its place.
    ///
    /// # Panics
    ///
    /// If there are not as many pixels as in a frame.
    pub fn write(&mut self, pixels: impl ExactSizeIterator<Item = T>) -> Result<(), SinkError> {
        self.stage(pixels)?;
        self.commit()
    }

    /// Appends one frame that [`ArrayWriter::commit`] counts, so that several files can grow together.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the file cannot take it.
    ///
    /// # Panics
    ///
    /// If there are not as many pixels as in a frame.
    pub fn stage(&mut self, pixels: impl ExactSizeIterator<Item = T>) -> Result<(), SinkError> {
        assert_eq!(pixels.len(), self.width * self.height, "pixels of a frame of {}", self.path.display());
        for (pixel, bytes) in pixels.zip(self.bytes.chunks_exact_mut(T::LEN)) {
            pixel.put(bytes);
        }
        let start = HEADER_LEN as u64 + self.frames * self.bytes.len() as u64;
        let written = self.to.seek(SeekFrom::Start(start)).and_then(|_| self.to.write_all(&self.bytes));
        written.map_err(SinkError::writing(&self.path))
    }

    /// Counts the staged frame.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the header cannot be rewritten.
    pub fn commit(&mut self) -> Result<(), SinkError> {
        self.frames += 1;
        self.write_header()
    }

    /// Bytes of the file.
    #[must_use]
    pub fn len_bytes(&self) -> u64 {
        HEADER_LEN as u64 + self.frames * self.bytes.len() as u64
    }

    fn write_header(&mut self) -> Result<(), SinkError> {
        let mut header = [b' '; HEADER_LEN];
        header[..PREAMBLE.len()].copy_from_slice(&PREAMBLE);
        header[HEADER_LEN - 1] = b'\n';
        let written = self
            .describe(&mut header[PREAMBLE.len()..HEADER_LEN - 1])
            .and_then(|()| self.to.seek(SeekFrom::Start(0)))
            .and_then(|_| self.to.write_all(&header));
        written.map_err(SinkError::writing(&self.path))
    }

    /// Writes the array's type and shape; 117 bytes are enough for five dimensions of any file that fits a disk.
    fn describe(&self, mut dictionary: &mut [u8]) -> std::io::Result<()> {
        let (frames, height, width) = (self.frames, self.height, self.width);
        write!(dictionary, "{{'descr': '{}', 'fortran_order': False, 'shape': (", T::DESCR)?;
        write!(dictionary, "{frames}, {height}, {width}")?;
        for channels in T::CHANNELS {
            write!(dictionary, ", {channels}")?;
        }
        write!(dictionary, "), }}")
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    /// A disk with room for this number of bytes.
    struct SmallDisk {
        file: Cursor<Vec<u8>>,
        room: usize,
    }

    impl Write for SmallDisk {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            let room = self.room.saturating_sub(self.file.position() as usize).min(bytes.len());
            match room {
                0 => Err(std::io::ErrorKind::StorageFull.into()),
                _ => self.file.write(&bytes[..room]),
            }
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    impl Seek for SmallDisk {
        fn seek(&mut self, position: SeekFrom) -> std::io::Result<u64> {
            self.file.seek(position)
        }
    }

    fn read(bytes: &[u8]) -> (Vec<u64>, Vec<f32>) {
        let file = npyz::NpyFile::new(bytes).unwrap();
        (file.shape().to_vec(), file.into_vec().unwrap())
    }

    #[test]
    fn every_frame_that_the_header_counts_can_be_read_after_the_disk_is_full() {
        let frame_len = 3 * 2 * 8;
        let disk = SmallDisk { file: Cursor::new(Vec::new()), room: HEADER_LEN + 2 * frame_len + 5 };
        let mut writer = ArrayWriter::new(disk, Path::new("flow.npy"), 3, 2).unwrap();
        let frame = |number: f32| (0..6).map(move |i| [number, i as f32]);
        writer.write(frame(0.0)).unwrap();
        writer.write(frame(1.0)).unwrap();
        let error = writer.write(frame(2.0)).unwrap_err();
        assert!(error.to_string().contains("flow.npy"), "{error}");
        assert!(error.hint().unwrap().contains("space"));

        let (shape, values) = read(writer.to.file.get_ref());
        assert_eq!(shape, [2, 2, 3, 2]);
        assert_eq!(values[12..16], [1.0, 0.0, 1.0, 1.0]);
    }

    #[test]
    fn a_frame_that_failed_is_replaced_by_the_next() {
        let disk = SmallDisk { file: Cursor::new(Vec::new()), room: HEADER_LEN + 3 };
        let mut writer = ArrayWriter::new(disk, Path::new("depth.npy"), 1, 1).unwrap();
        writer.write([7.0].into_iter()).unwrap_err();
        writer.to.room = usize::MAX;
        writer.write([8.0].into_iter()).unwrap();
        assert_eq!(read(writer.to.file.get_ref()), (vec![1, 1, 1], vec![8.0]));
    }

    #[test]
    fn a_staged_frame_is_not_counted() {
        let mut writer = ArrayWriter::new(Cursor::new(Vec::new()), Path::new("depth.npy"), 1, 1).unwrap();
        writer.stage([7.0].into_iter()).unwrap();
        assert_eq!(read(writer.to.get_ref()).0, [0, 1, 1]);
        writer.commit().unwrap();
        assert_eq!(read(writer.to.get_ref()).0, [1, 1, 1]);
    }

    #[test]
    fn the_longest_header_fits() {
        let mut writer = ArrayWriter::<[f32; 3], _>::new(Cursor::new(Vec::new()), Path::new("x.npy"), 1, 1).unwrap();
        (writer.frames, writer.width, writer.height) = (u64::MAX, 999_999, 999_999);
        writer.write_header().unwrap();
    }
}

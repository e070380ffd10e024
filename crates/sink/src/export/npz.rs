//! One file for `NumPy`: the arrays of a run, the columns of its table, and its `run.toml`, without compression, in the
//! format of `numpy.savez`.

use std::fs::{self, File};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::Path;

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use super::RunArrays;
use crate::SinkError;

/// In this format the values start at a multiple of this, bytes.
const ALIGNMENT: usize = 64;

/// Writes a run as a `.npz` file: `numpy.load(PATH)["depth"]`. The columns of the table have their own names, and
/// `run.toml` is included unchanged.
///
/// # Errors
///
/// [`SinkError::Write`] if the file cannot be written, [`SinkError::Read`] if the run cannot be read. After an
/// error the file is deleted, because an incomplete one cannot be read.
pub fn write_npz(run: &RunArrays, path: &Path) -> Result<(), SinkError> {
    let file = File::create(path).map_err(SinkError::writing(path))?;
    let is_file = file.metadata().is_ok_and(|about| about.is_file());
    let written = write_archive(run, path, file);
    if written.is_err() && is_file {
        // What cannot be removed stays: the error that is reported is the one that matters.
        let _ = fs::remove_file(path);
    }
    written
}

fn write_archive(run: &RunArrays, path: &Path, file: File) -> Result<(), SinkError> {
    let writing = || SinkError::writing(path);
    let mut zip = ZipWriter::new(Archive { file: BufWriter::new(file), has_failed: false, place: 0, len: 0 });
    for array in &run.arrays {
        let mut values = array.values()?;
        begin(&mut zip, array.name, &array.descr, &array.shape).map_err(writing())?;
        io::copy(&mut values, &mut zip).map_err(writing())?;
    }
    for (name, column) in &run.table.columns {
        let begun = begin(&mut zip, name, &column.descr(), &[column.rows() as u64]);
        begun.and_then(|()| zip.write_all(&column.bytes())).map_err(writing())?;
    }
    let record = zip.start_file("run.toml", options()).map_err(io::Error::from);
    record.and_then(|()| zip.write_all(run.record.as_bytes())).map_err(writing())?;
    let mut archive = zip.finish().map_err(io::Error::from).map_err(writing())?;
    archive.file.flush().and_then(|()| archive.file.get_ref().sync_all()).map_err(writing())
}

/// A file that after its first error seems to take everything: a [`ZipWriter`] writes once more when it is dropped, and would
/// print that error, too.
struct Archive {
    file: BufWriter<File>,
    has_failed: bool,
    /// Where the next byte comes, and the length so far; also after an error.
    place: u64,
    len: u64,
}

impl Archive {
    fn note<T>(&mut self, done: io::Result<T>) -> io::Result<T> {
        self.has_failed |= done.is_err();
        done
    }
}

impl Write for Archive {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let done = if self.has_failed { Ok(bytes.len()) } else { self.file.write(bytes) };
        let count = self.note(done)?;
        self.place += count as u64;
        self.len = self.len.max(self.place);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        let done = if self.has_failed { Ok(()) } else { self.file.flush() };
        self.note(done)
    }
}

impl Seek for Archive {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let place = match to {
            SeekFrom::Start(place) => Some(place),
            SeekFrom::Current(by) => self.place.checked_add_signed(by),
            SeekFrom::End(by) => self.len.checked_add_signed(by),
        };
        let place = place.ok_or(io::ErrorKind::InvalidInput)?;
        let done = if self.has_failed { Ok(place) } else { self.file.seek(SeekFrom::Start(place)) };
        self.place = self.note(done)?;
        Ok(self.place)
    }
}

fn options() -> SimpleFileOptions {
    SimpleFileOptions::default().compression_method(CompressionMethod::Stored).large_file(true)
}

fn begin(zip: &mut ZipWriter<Archive>, name: &str, descr: &str, shape: &[u64]) -> io::Result<()> {
    zip.start_file(format!("{name}.npy"), options())?;
    zip.write_all(&header(descr, shape))
}

/// The header of an array of version 1.0.
fn header(descr: &str, shape: &[u64]) -> Vec<u8> {
    let lengths = shape.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
    let mut text = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({lengths},), }}");
    let len = (10 + text.len() + 1).next_multiple_of(ALIGNMENT);
    text.extend(std::iter::repeat_n(' ', len - 11 - text.len()));
    text.push('\n');
    let text_len = text.len() as u16;
    [b"\x93NUMPY\x01\x00".as_slice(), &text_len.to_le_bytes(), text.as_bytes()].concat()
}

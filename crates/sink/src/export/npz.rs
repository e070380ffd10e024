//! One file for `NumPy`: the arrays of a run, the columns of its table, and its `run.toml`, without compression, in the
//! format of `numpy.savez`.

use std::fs::File;
use std::io::{self, BufWriter, Write};
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
/// [`SinkError::Write`] if the file cannot be written, [`SinkError::Read`] if the run cannot be read.
pub fn write_npz(run: &RunArrays, path: &Path) -> Result<(), SinkError> {
    let writing = || SinkError::writing(path);
    let file = File::create(path).map_err(writing())?;
    let mut zip = ZipWriter::new(BufWriter::new(file));
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
    let mut file = zip.finish().map_err(io::Error::from).map_err(writing())?;
    file.flush().and_then(|()| file.get_ref().sync_all()).map_err(writing())
}

fn options() -> SimpleFileOptions {
    SimpleFileOptions::default().compression_method(CompressionMethod::Stored).large_file(true)
}

fn begin(zip: &mut ZipWriter<BufWriter<File>>, name: &str, descr: &str, shape: &[u64]) -> io::Result<()> {
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

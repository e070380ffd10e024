//! The arrays of a run folder, to be copied: their names, types and shapes, and where their values start.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::run_table::RunTable;
use crate::{Field, SinkError};

/// Bytes before the header's text: magic string, version 1.0 and the text's length.
const PREAMBLE_LEN: u64 = 10;

/// What a run folder contains.
#[derive(Debug)]
pub struct RunArrays {
    /// The arrays of fields, as files of the folder.
    pub arrays: Vec<RunArray>,
    /// The table of readings.
    pub table: RunTable,
    /// The text of `run.toml`.
    pub record: String,
}

/// An array of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunArray {
    /// The field's name.
    pub name: &'static str,
    /// The type of a number, as in `.npy` files: `<f4`, `<f2` or `|u1`.
    pub descr: String,
    /// Lengths of the dimensions, of which the first is the number of frames.
    pub shape: Vec<u64>,
    path: PathBuf,
    data_start: u64,
}

impl RunArrays {
    /// Opens a run folder.
    ///
    /// # Errors
    ///
    /// [`SinkError::NotARun`] if the folder is not one, [`SinkError::Read`] if the system refuses.
    pub fn open(folder: &Path) -> Result<Self, SinkError> {
        let reading = |path: PathBuf| move |error| SinkError::Read { path, error };
        let text = |name: &str| {
            let path = folder.join(name);
            if !path.is_file() {
                return Err(SinkError::NotARun { path: folder.to_owned(), reason: format!("it has no {name}") });
            }
            std::fs::read_to_string(&path).map_err(reading(path))
        };
        let (table, record) = (text("readings.csv")?, text("run.toml")?);
        let table = RunTable::of(&table);
        let mut arrays = Vec::new();
        let files = Field::ALL.iter().map(|field| (field.name(), field.file_name())).chain([("valid", "valid.npy")]);
        for (name, file) in files {
            let path = folder.join(file);
            if path.is_file() {
                arrays.push(RunArray::open(name, path)?);
            }
        }
        Ok(Self { arrays, table, record })
    }
}

impl RunArray {
    fn open(name: &'static str, path: PathBuf) -> Result<Self, SinkError> {
        let mut file = File::open(&path).map_err(|error| SinkError::Read { path: path.clone(), error })?;
        let mut preamble = [0; PREAMBLE_LEN as usize];
        let mut header = Vec::new();
        let read = file.read_exact(&mut preamble).and_then(|()| {
            let len = u64::from(u16::from_le_bytes([preamble[8], preamble[9]]));
            file.take(len).read_to_end(&mut header)
        });
        read.map_err(|error| SinkError::Read { path: path.clone(), error })?;
        let data_start = PREAMBLE_LEN + header.len() as u64;
        let header = String::from_utf8_lossy(&header);
        match parsed(&header).filter(|_| preamble.starts_with(b"\x93NUMPY\x01")) {
            Some((descr, shape)) => Ok(Self { name, descr, shape, path, data_start }),
            None => Err(SinkError::NotARun { reason: "it is not an array of version 1.0".into(), path }),
        }
    }

    /// Bytes of a number.
    #[must_use]
    pub fn number_len(&self) -> u64 {
        self.descr.chars().last().and_then(|digit| digit.to_digit(10)).map_or(1, u64::from)
    }

    /// Bytes of a frame.
    #[must_use]
    pub fn frame_len(&self) -> u64 {
        self.shape.iter().skip(1).product::<u64>() * self.number_len()
    }

    /// The values, frame after frame; bytes of an unfinished frame may follow.
    ///
    /// # Errors
    ///
    /// [`SinkError::Read`] if the system refuses.
    pub(crate) fn values(&self) -> Result<impl Read + use<>, SinkError> {
        let read = || -> io::Result<File> {
            let mut file = File::open(&self.path)?;
            file.seek(SeekFrom::Start(self.data_start))?;
            Ok(file)
        };
        let len = self.frame_len() * self.shape.first().copied().unwrap_or(0);
        read().map(|file| file.take(len)).map_err(|error| SinkError::Read { path: self.path.clone(), error })
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }
}

/// Type and shape in a header such as `{'descr': '<f4', 'fortran_order': False, 'shape': (3, 4, 5), }`.
fn parsed(header: &str) -> Option<(String, Vec<u64>)> {
    let (_, descr) = header.split_once("'descr': '")?;
    let (descr, rest) = descr.split_once('\'')?;
    let (_, shape) = rest.split_once("'shape': (")?;
    let (shape, _) = shape.split_once(')')?;
    let lengths = shape.split(',').map(str::trim).filter(|length| !length.is_empty());
    let shape: Vec<u64> = lengths.map(|length| length.parse().ok()).collect::<Option<_>>()?;
    let is_known = ["<f4", "<f2", "|u1"].contains(&descr) && rest.contains("'fortran_order': False");
    is_known.then(|| (descr.to_owned(), shape))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_are_taken_apart() {
        let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (3, 40, 50, 2), }          \n";
        assert_eq!(parsed(header), Some(("<f4".into(), vec![3, 40, 50, 2])));
        assert_eq!(parsed("{'descr': '>f4', 'fortran_order': False, 'shape': (3,), }"), None);
        assert_eq!(parsed("{'descr': '<f4', 'fortran_order': True, 'shape': (3,), }"), None);
        assert_eq!(parsed(""), None);
    }
}

//! A text file that grows by whole rows.

use std::fs::File;
use std::io::{Seek, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use crate::SinkError;

/// A file of rows. Each is written to the file at once; one that does not fit the disk is cut off again, so no partial
/// number is left.
#[derive(Debug)]
pub struct Rows {
    path: PathBuf,
    file: File,
    row: String,
    len: u64,
}

impl Rows {
    /// Creates the file, or empties it, and writes the names of the columns.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the file cannot be written.
    pub fn create(path: &Path, columns: &[&str]) -> Result<Self, SinkError> {
        let file = File::create(path).map_err(SinkError::writing(path))?;
        let mut rows = Self { path: path.to_path_buf(), file, row: columns.join(","), len: 0 };
        rows.append()?;
        Ok(rows)
    }

    /// Appends the row that `write` writes.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the file cannot take it.
    pub fn write(&mut self, write: impl FnOnce(&mut String) -> std::fmt::Result) -> Result<(), SinkError> {
        self.row.clear();
        // Writing to a String cannot fail.
        let _ = write(&mut self.row);
        self.append()
    }

    /// Flushes everything to the disk.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the disk refuses it.
    pub fn finish(self) -> Result<(), SinkError> {
        self.file.sync_all().map_err(SinkError::writing(&self.path))
    }

    /// Bytes of the file.
    #[must_use]
    pub fn len_bytes(&self) -> u64 {
        self.len
    }

    fn append(&mut self) -> Result<(), SinkError> {
        self.row.push('\n');
        if let Err(error) = self.file.write_all(self.row.as_bytes()) {
            // The first error is reported; if the cut fails too, the row only stays incomplete.
            let _ = self.file.set_len(self.len).and_then(|()| self.file.seek(SeekFrom::Start(self.len)));
            return Err(SinkError::Write { path: self.path.clone(), error });
        }
        self.len += self.row.len() as u64;
        Ok(())
    }
}

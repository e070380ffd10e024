//! `readings.csv`: the numbers of each reading, a row a frame.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{Seek, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use fingervision_touch::Reading;

use crate::SinkError;

/// The columns of the table, in order.
pub const COLUMNS: [&str; 12] = [
    "sequence",
    "capture_time_s",
    "reference_id",
    "reference_count",
    "photometric_error",
    "max_depth_mm",
    "contact_area_mm2",
    "force_x_n",
    "force_y_n",
    "force_z_n",
    "latency_ms",
    "flags",
];

/// A table with a row for each reading; an absent value is an empty cell.
///
/// Each row reaches the file at once. A row that does not fit the disk is cut off again, so no half number is left.
#[derive(Debug)]
pub struct Table {
    path: PathBuf,
    file: File,
    row: String,
    len: u64,
}

impl Table {
    /// Creates the file, or empties it, and writes the names of the columns.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the file cannot be written.
    pub fn create(path: &Path) -> Result<Self, SinkError> {
        let file = File::create(path).map_err(SinkError::writing(path))?;
        let mut table = Self { path: path.to_path_buf(), file, row: COLUMNS.join(","), len: 0 };
        table.append()?;
        Ok(table)
    }

    /// Appends the row of a reading.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the file cannot take it.
    pub fn write(&mut self, reading: &Reading) -> Result<(), SinkError> {
        self.row.clear();
        // Writing to a String cannot fail.
        let _ = write_row(&mut self.row, reading);
        self.append()
    }

    /// Puts all that was written onto the disk.
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
            // The first error is the one to report; should the cut fail too, the row merely stays incomplete.
            let _ = self.file.set_len(self.len).and_then(|()| self.file.seek(SeekFrom::Start(self.len)));
            return Err(SinkError::Write { path: self.path.clone(), error });
        }
        self.len += self.row.len() as u64;
        Ok(())
    }
}

fn write_row(row: &mut String, reading: &Reading) -> std::fmt::Result {
    write!(row, "{},{},", reading.sequence, reading.capture_time_s)?;
    write!(row, "{},{},", reading.reference_id, reading.reference_count)?;
    write!(row, "{},", reading.photometric_error)?;
    let force = reading.force_n.map_or([None; 3], |force| force.map(Some));
    for value in [reading.max_depth_mm, reading.contact_area_mm2].into_iter().chain(force) {
        if let Some(value) = value {
            write!(row, "{value}")?;
        }
        row.push(',');
    }
    write!(row, "{:.3},{}", reading.latency_ms, reading.flags)
}

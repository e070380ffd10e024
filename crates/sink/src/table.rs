//! `readings.csv`: the numbers of each reading, one row per frame.

use std::fmt::Write as _;
use std::path::Path;

use fingervision_touch::{
    CONTACT_AREA_COLUMN, FORCE_COLUMNS, MAX_DEPTH_COLUMN, ReadingNumbers, SEQUENCE_COLUMN, TORQUE_COLUMN,
};

use crate::SinkError;
use crate::rows::Rows;

/// The columns of the table, in order.
pub const COLUMNS: [&str; 13] = [
    SEQUENCE_COLUMN,
    "capture_time_s",
    "reference_id",
    "reference_count",
    "photometric_error",
    MAX_DEPTH_COLUMN,
    CONTACT_AREA_COLUMN,
    FORCE_COLUMNS[0],
    FORCE_COLUMNS[1],
    FORCE_COLUMNS[2],
    "latency_ms",
    "flags",
    TORQUE_COLUMN,
];

/// A table with a row for each reading; an absent value is an empty cell.
///
/// Each row is written to the file at once. A row that does not fit the disk is cut off again, so no partial number is
/// left.
#[derive(Debug)]
pub struct Table {
    rows: Rows,
}

impl Table {
    /// Creates the file, or empties it, and writes the names of the columns.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the file cannot be written.
    pub fn create(path: &Path) -> Result<Self, SinkError> {
        Ok(Self { rows: Rows::create(path, &COLUMNS)? })
    }

    /// Appends the row of a reading.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the file cannot take it.
    pub fn write(&mut self, reading: &ReadingNumbers) -> Result<(), SinkError> {
        self.rows.write(|row| write_row(row, reading))
    }

    /// Flushes everything to the disk.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the disk refuses it.
    pub fn finish(self) -> Result<(), SinkError> {
        self.rows.finish()
    }

    /// Bytes of the file.
    #[must_use]
    pub fn len_bytes(&self) -> u64 {
        self.rows.len_bytes()
    }
}

fn write_row(row: &mut String, reading: &ReadingNumbers) -> std::fmt::Result {
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
    write!(row, "{:.3},{},", reading.latency_ms, reading.flags)?;
    reading.torque_nmm.map_or(Ok(()), |torque| write!(row, "{torque}"))
}

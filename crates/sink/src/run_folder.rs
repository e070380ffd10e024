//! The folder of a run: arrays, the table and `run.toml`.

use std::fs;
use std::path::{Path, PathBuf};

use fingervision_image::Frame;
use fingervision_touch::Reading;

use crate::claim::{FolderKind, FolderLock};
use crate::run_fields::RunFields;
use crate::whole_file::write_file;
use crate::{Field, RunOptions, Sink, SinkError, Table};

/// The contents of a run; `run.toml` describes how it was made.
const RUN: FolderKind = FolderKind {
    noun: "run",
    marker: "run.toml",
    files: &[
        Field::Flow.file_name(),
        Field::Density.file_name(),
        Field::Depth.file_name(),
        Field::DepthValid.file_name(),
        Field::DepthDeviation.file_name(),
        Field::Contact.file_name(),
        Field::Deviation.file_name(),
        Field::Displacement.file_name(),
        Field::Traction.file_name(),
        "valid.npy",
        "readings.csv",
        "preview.png",
        "overlay.avi",
        "report.html",
        "evaluation/evaluation.png",
    ],
    images: None,
    folders: &["evaluation"],
};

/// The contents of a finished run.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct RunSummary {
    /// The folder.
    pub folder: PathBuf,
    /// Readings written.
    pub frames: u64,
    /// Size of arrays and table, bytes.
    pub bytes: u64,
}

/// A folder that takes readings, one after another, in constant memory.
///
/// After every reading the files can be read up to and including it. If the run ends between two files, one of them may
/// be a frame ahead: the shortest one determines the number of complete frames.
#[derive(Debug)]
pub struct RunFolder {
    path: PathBuf,
    frames: u64,
    fields: RunFields,
    table: Table,
    lock: FolderLock,
}

impl RunFolder {
    /// Prepares a folder for a run and writes `run_toml`, which describes how the run is made.
    ///
    /// A folder that contains a previous run is refused, or with [`RunOptions::overwrite`] its files are removed first.
    /// A folder that holds anything else is always refused.
    ///
    /// # Errors
    ///
    /// [`SinkError::Busy`], [`SinkError::Previous`] or [`SinkError::FolderNotEmpty`] if the folder is taken, [`SinkError::Write`] if it
    /// or a file in it cannot be written.
    pub fn create(path: &Path, options: &RunOptions, run_toml: &str) -> Result<Self, SinkError> {
        let lock = RUN.claim(path, options.overwrite)?;
        write_file(&path.join(RUN.marker), run_toml.as_bytes())?;
        let fields = RunFields::create(path, options)?;
        let table = Table::create(&path.join("readings.csv"))?;
        Ok(Self { path: path.to_path_buf(), frames: 0, fields, table, lock })
    }

    /// Refuses a folder that [`create`](Self::create) would refuse because of its content; changes nothing.
    ///
    /// # Errors
    ///
    /// [`SinkError::Previous`] or [`SinkError::FolderNotEmpty`] if the folder is taken, [`SinkError::Write`] if there is a
    /// file of this name.
    pub fn check(path: &Path, overwrite: bool) -> Result<(), SinkError> {
        RUN.check(path, overwrite)
    }

    /// The folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Flushes everything to the disk and returns a summary.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the disk refuses a file.
    pub fn finish(self) -> Result<RunSummary, SinkError> {
        let bytes = self.table.len_bytes() + self.fields.len_bytes();
        self.table.finish()?;
        self.fields.finish()?;
        drop(self.lock);
        Ok(RunSummary { folder: self.path, frames: self.frames, bytes })
    }

    /// Removes the files of a run without any reading, and the folder if nothing else is in it.
    pub fn discard(self) {
        let Self { path, fields, table, lock, .. } = self;
        drop((fields, table));
        // What cannot be removed stays: the caller reports why there is no reading.
        let _ = RUN.empty(&path);
        drop(lock);
        let _ = fs::remove_dir(&path);
    }
}

impl Sink for RunFolder {
    /// Appends a reading to every file of the run; the frame is not kept.
    ///
    /// # Errors
    ///
    /// [`SinkError::SizeMismatch`] or [`SinkError::FieldAbsent`] if the reading lacks what the run keeps,
    /// [`SinkError::Write`] if a file cannot take it. The reading then is in no file.
    fn write(&mut self, reading: &Reading, _frame: &Frame) -> Result<(), SinkError> {
        self.fields.stage(reading)?;
        self.table.write(&reading.numbers)?;
        self.fields.commit()?;
        self.frames += 1;
        Ok(())
    }
}

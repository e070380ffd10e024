//! A folder with a report: a page for people and a file with its numbers.

use std::fs;
use std::path::{Path, PathBuf};

use fingervision_evaluate::page::Page;
use fingervision_sink::{FolderKind, FolderLock, SinkError, write_file};
use serde::Serialize;

use crate::failure::Failure;

const PAGE: &str = "report.html";
const NUMBERS: &str = "report.json";

/// The contents of such a folder. The scenes of a benchmark are kept: the next one overwrites them.
const REPORT: FolderKind = FolderKind { noun: "report", marker: PAGE, files: &[NUMBERS], images: None, folders: &[] };
/// Placeholder of the page while the report is made, so that an earlier one is not mistaken for it.
const UNDER_WAY: &str =
    "<!doctype html><meta charset=\"utf-8\"><title>fingervision</title><p>This report is not finished.</p>\n";

/// A folder for a report.
#[derive(Debug)]
pub(crate) struct ReportFolder {
    path: PathBuf,
    lock: FolderLock,
}

impl ReportFolder {
    /// Creates the folder before anything is computed, so that an error is reported early. An earlier report there is
    /// replaced only if requested.
    pub(crate) fn create(path: &Path, overwrite: bool) -> Result<Self, Failure> {
        let folder = Self { path: path.to_owned(), lock: REPORT.claim(path, overwrite)? };
        folder.add(PAGE, UNDER_WAY.as_bytes())?;
        Ok(folder)
    }

    /// Writes a file into the folder.
    pub(crate) fn add(&self, name: &str, bytes: &[u8]) -> Result<(), Failure> {
        let path = self.path.join(name);
        let parent = path.parent().unwrap_or(&self.path);
        fs::create_dir_all(parent).map_err(SinkError::writing(parent))?;
        Ok(write_file(&path, bytes)?)
    }

    /// Writes the numbers and the page; returns the page's path.
    pub(crate) fn write(self, numbers: &impl Serialize, page: &Page) -> Result<PathBuf, Failure> {
        let json = serde_json::to_string_pretty(numbers).map_err(std::io::Error::from)?;
        self.add(NUMBERS, json.as_bytes())?;
        self.add(PAGE, page.html().as_bytes())?;
        drop(self.lock);
        Ok(self.path.join(PAGE))
    }
}

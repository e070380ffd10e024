//! A folder with a report: a page to look at and its numbers.

use std::fs;
use std::path::{Path, PathBuf};

use fingervision_evaluate::page::Page;
use serde::Serialize;

use crate::failure::Failure;

const PAGE: &str = "report.html";
const NUMBERS: &str = "report.json";

/// A folder that takes a report; an earlier one there is replaced.
#[derive(Debug)]
pub(crate) struct ReportFolder(PathBuf);

impl ReportFolder {
    /// Makes the folder, so that what cannot be written shows before anything is computed.
    pub(crate) fn create(path: &Path) -> Result<Self, Failure> {
        fs::create_dir_all(path).map_err(|error| refused(path, &error))?;
        let folder = Self(path.to_owned());
        // An earlier report shall not be taken for the one under way.
        for name in [PAGE, NUMBERS] {
            match fs::remove_file(path.join(name)) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(refused(path, &error)),
                _ => {}
            }
        }
        Ok(folder)
    }

    /// Writes a file into the folder.
    pub(crate) fn add(&self, name: &str, bytes: &[u8]) -> Result<(), Failure> {
        let path = self.0.join(name);
        let parent = path.parent().unwrap_or(&self.0);
        fs::create_dir_all(parent).and_then(|()| fs::write(&path, bytes)).map_err(|error| refused(&path, &error))
    }

    /// Writes the numbers and the page; where the page is.
    pub(crate) fn write(&self, numbers: &impl Serialize, page: &Page) -> Result<PathBuf, Failure> {
        let json = serde_json::to_string_pretty(numbers).map_err(std::io::Error::from)?;
        self.add(NUMBERS, json.as_bytes())?;
        self.add(PAGE, page.html().as_bytes())?;
        Ok(self.0.join(PAGE))
    }
}

fn refused(path: &Path, error: &std::io::Error) -> Failure {
    let message = format!("{}: it cannot be written: {error}", path.display());
    Failure::new(message, "choose a folder that can be written to, with --out")
}

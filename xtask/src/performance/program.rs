//! Runs the `fingervision` command, and reads what it reports.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result};
use serde_json::Value;

use crate::expect_success;

/// The built command, and a folder for its files.
pub(super) struct Program {
    path: PathBuf,
    pub(super) folder: PathBuf,
}

impl Program {
    /// Builds the command.
    pub(super) fn build() -> Result<Self> {
        let path = crate::build_command()?;
        let folder = crate::target_folder().join("performance");
        if folder.exists() {
            fs::remove_dir_all(&folder)?;
        }
        fs::create_dir_all(&folder)?;
        Ok(Self { path, folder })
    }

    /// Runs it with `--json`, and returns its report.
    pub(super) fn report(&self, arguments: &[&str]) -> Result<Value> {
        let output = expect_success(Command::new(&self.path).args(arguments).args(["--json", "--quiet"]))?;
        serde_json::from_slice(&output).with_context(|| format!("fingervision {} printed no JSON", arguments.join(" ")))
    }

    /// Runs it; returns how long it took, s.
    pub(super) fn time_s(&self, arguments: &[&str]) -> Result<f64> {
        let start = Instant::now();
        expect_success(Command::new(&self.path).args(arguments).arg("--quiet"))?;
        Ok(start.elapsed().as_secs_f64())
    }

    /// A path in the folder, as an argument.
    pub(super) fn file(&self, name: &str) -> String {
        self.folder.join(name).display().to_string()
    }
}

/// A number in a report; keys are separated by `/`.
pub(super) fn number(report: &Value, place: &str) -> Result<f64> {
    let found = report.pointer(&format!("/{place}")).and_then(Value::as_f64);
    found.with_context(|| format!("the report has no number {place}"))
}

/// Reads a JSON file.
pub(super) fn read(path: &Path) -> Result<Value> {
    let text = fs::read_to_string(path).with_context(|| format!("{} cannot be read", path.display()))?;
    serde_json::from_str(&text).with_context(|| format!("{} is not JSON", path.display()))
}

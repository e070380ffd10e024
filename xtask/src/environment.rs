//! Environments of Python in the target folder. One is kept as long as the same packages are asked for.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::expect_success;

/// The oldest Python that the wheel is for.
const OLDEST: &str = "3.10";
/// In a complete environment: the interpreter's version and the packages that were asked for.
const CONTENTS: &str = "contents.txt";

/// An interpreter, outside any environment.
pub(crate) struct Interpreter {
    path: PathBuf,
    version: String,
}

impl Interpreter {
    /// `FINGERVISION_PYTHON`, or `python3`.
    pub(crate) fn find() -> Result<Self> {
        let path = PathBuf::from(env::var_os("FINGERVISION_PYTHON").unwrap_or_else(|| "python3".into()));
        let code = "import sys; print(sys.version.split()[0]); sys.exit(sys.version_info < (3, 10))";
        let output = Command::new(&path).args(["-c", code]).output();
        let output = output.with_context(|| format!("{} cannot be run", path.display()))?;
        let version = String::from_utf8_lossy(&output.stdout).trim().to_owned();
        ensure!(output.status.success(), "{} is Python {version}, and {OLDEST} is needed", path.display());
        Ok(Self { path, version })
    }

    /// The interpreter of the environment in a folder, with these packages, and with others without what they need. It is
    /// made anew unless it has them already.
    pub(crate) fn environment(&self, folder: &Path, packages: &[&str], bare: &[&str]) -> Result<PathBuf> {
        let own = folder.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
        let contents = format!("{}\n{}\n--no-deps\n{}\n", self.version, packages.join("\n"), bare.join("\n"));
        if fs::read_to_string(folder.join(CONTENTS)).is_ok_and(|found| found == contents) {
            return Ok(own);
        }
        if folder.exists() {
            fs::remove_dir_all(folder)?;
        }
        expect_success(Command::new(&self.path).args(["-m", "venv"]).arg(folder))?;
        install(&own, packages)?;
        if !bare.is_empty() {
            install(&own, &[&["--no-deps"], bare].concat())?;
        }
        fs::write(folder.join(CONTENTS), contents)?;
        Ok(own)
    }
}

/// Installs packages into an interpreter's environment.
pub(crate) fn install(python: &Path, packages: &[&str]) -> Result<()> {
    let install = ["-m", "pip", "install", "--quiet", "--retries", "2", "--disable-pip-version-check"];
    let output = Command::new(python).args(install).args(packages).output();
    let output = output.with_context(|| format!("{} cannot be run", python.display()))?;
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    // Before the last line pip repeats itself for each try.
    let reason = errors.trim().lines().rfind(|line| line.starts_with("ERROR")).unwrap_or(errors.trim());
    ensure!(output.status.success(), "pip cannot install {}: {reason}", packages.join(", "));
    Ok(())
}

/// Installs a distribution from a wheel or a folder, in the place of the one that is installed.
pub(crate) fn replace(python: &Path, name: &str, from: &Path, options: &[&str]) -> Result<()> {
    let uninstall = ["-m", "pip", "uninstall", "--quiet", "--yes", "--disable-pip-version-check", name];
    expect_success(Command::new(python).args(uninstall))?;
    install(python, &[options, &[from.to_string_lossy().as_ref()]].concat())
}

pub(crate) fn is_installed(python: &Path, library: &str) -> Result<bool> {
    let code = "import importlib.util, sys; sys.exit(importlib.util.find_spec(sys.argv[1]) is None)";
    Ok(Command::new(python).args(["-c", code, library]).status()?.success())
}

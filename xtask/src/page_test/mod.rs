//! `cargo xtask page-test`: the page of `fingervision live` in a browser.
//!
//! The tests are in `crates/page/tests/browser/`. They drive Chromium through Playwright, which is installed in an environment in
//! the target folder; Chromium itself is that of the system. Where it is missing, or Python, or its packages, the tests are
//! skipped, and a line says why. Screenshots of a desk and of a phone, light and dark, are kept for a person to look at.

use std::env;
use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::environment::Interpreter;

const PACKAGES: [&str; 2] = ["playwright>=1.49,<2", "pytest>=8,<9"];
/// Names of Chromium's command.
const BROWSERS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// Options of the tests.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Fail instead of skipping the tests where Chromium, Python or packages are missing.
    #[arg(long)]
    required: bool,
    /// Test the command of the development profile, as `cargo test` has built it.
    #[arg(long)]
    dev: bool,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<()> {
    let folder = crate::target_folder().join("page-test");
    let needed = tools(&folder);
    let Some((chromium, python)) = crate::unless_missing("page-test", needed, args.required, out)? else {
        return Ok(());
    };
    let command = if args.dev { crate::target_folder().join("debug/fingervision") } else { crate::build_command()? };
    let screenshots = folder.join("screenshots");
    if screenshots.exists() {
        fs::remove_dir_all(&screenshots).with_context(|| screenshots.display().to_string())?;
    }
    fs::create_dir_all(&screenshots).with_context(|| screenshots.display().to_string())?;
    let mut pytest = Command::new(python);
    // Nothing is written beside the sources.
    pytest.args(["-B", "-m", "pytest", "-q", "-p", "no:cacheprovider"]);
    pytest.arg(crate::workspace().join("crates/page/tests/browser"));
    pytest.env("FINGERVISION_COMMAND", fs::canonicalize(&command).with_context(|| command.display().to_string())?);
    pytest.env("FINGERVISION_CHROMIUM", chromium);
    pytest.env("FINGERVISION_SCREENSHOTS", fs::canonicalize(&screenshots)?);
    let status = pytest.status().context("pytest cannot be run")?;
    ensure!(status.success(), "the page has faults");
    let figures = fs::read_to_string(screenshots.join("figures.txt")).context("the tests wrote no figures")?;
    writeln!(out, "page-test: {}; screenshots in {}", figures.trim(), screenshots.display())?;
    Ok(())
}

/// Chromium, and an interpreter that has Playwright.
fn tools(folder: &std::path::Path) -> Result<(PathBuf, PathBuf)> {
    let chromium = chromium().context(
        "Chromium is missing: install it (on Debian: apt install chromium), or set FINGERVISION_CHROMIUM to its path",
    )?;
    let python = Interpreter::find()?.environment(&folder.join("tools"), &PACKAGES, &[])?;
    Ok((chromium, python))
}

/// `FINGERVISION_CHROMIUM`, or Chromium on the path.
fn chromium() -> Option<PathBuf> {
    if let Some(path) = env::var_os("FINGERVISION_CHROMIUM") {
        return Some(path.into());
    }
    let folders: Vec<PathBuf> = env::split_paths(&env::var_os("PATH")?).collect();
    BROWSERS.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name))).find(|path| path.is_file())
}

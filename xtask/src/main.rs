//! Checks and measurements of the workspace: `cargo xtask accuracy`, `cargo xtask layers`, `cargo xtask circles`,
//! `cargo xtask check`, `cargo xtask camera-test`, `cargo xtask page-test`, `cargo xtask python`, `cargo xtask site`,
//! `cargo xtask instructions`, `cargo xtask performance`, `cargo xtask soak`.

mod accuracy;
#[cfg(unix)]
mod camera_test;
mod check;
mod circles;
mod environment;
mod instructions;
mod layers;
mod lengths;
mod page_test;
mod performance;
mod python;
mod site;
#[cfg(target_os = "linux")]
mod soak;

use anyhow::{Context, Result, ensure};
use clap::{Parser, Subcommand};
use std::path::PathBuf;
use std::process::{Command, ExitCode};

/// The command's features that are off by default, as an argument of cargo: checks and tests use them.
const FEATURES: &str = "--features=fingervision-cli/foxglove,fingervision-cli/mp4";

/// Chores of the workspace.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask")]
struct Chore {
    #[command(subcommand)]
    name: Name,
}

#[derive(Debug, Subcommand)]
enum Name {
    /// Print how accurate the tracker is, beside what is asked.
    Accuracy(accuracy::Args),
    /// Check that crates depend only on crates below them.
    Layers,
    /// Check that files side by side do not import each other in a circle.
    Circles,
    /// Check format, lints, documentation, layers, circles and file lengths.
    Check,
    /// Test cameras on a real kernel in an emulator.
    #[cfg(unix)]
    CameraTest(camera_test::Args),
    /// Test the page of live sensors in Chromium.
    PageTest(page_test::Args),
    /// Build the Python wheel and test it in an environment of its own.
    Python(python::Args),
    /// Build the documentation as a site.
    Site(site::Args),
    /// Build the Python module; for maturin alone, which takes this program for cargo.
    #[command(name = "rustc", hide = true)]
    PythonModule(python::module::Args),
    /// Count the instructions of a frame and compare them with the record.
    Instructions(instructions::Args),
    /// Measure the tables of docs/performance.md.
    Performance(performance::Args),
    /// Run sensors with a page and a recording for long: nothing may be dropped, and memory must not grow.
    #[cfg(target_os = "linux")]
    Soak(soak::Args),
}

fn main() -> ExitCode {
    let outcome = match Chore::parse().name {
        Name::Accuracy(args) => accuracy::run(&args, &mut std::io::stdout().lock()),
        Name::Layers => layers::run(&mut std::io::stdout().lock()),
        Name::Circles => circles::run(&mut std::io::stdout().lock()),
        Name::Check => check::run(&mut std::io::stdout().lock()),
        #[cfg(unix)]
        Name::CameraTest(args) => camera_test::run(&args, &mut std::io::stdout().lock()),
        Name::PageTest(args) => page_test::run(&args, &mut std::io::stdout().lock()),
        Name::Python(args) => python::run(&args, &mut std::io::stdout().lock()),
        Name::Site(args) => site::run(&args, &mut std::io::stdout().lock()),
        Name::PythonModule(args) => python::module::run(&args),
        Name::Instructions(args) => instructions::run(&args, &mut std::io::stdout().lock()),
        Name::Performance(args) => performance::run(&args, &mut std::io::stdout().lock()),
        #[cfg(target_os = "linux")]
        Name::Soak(args) => soak::run(&args, &mut std::io::stdout().lock()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// What a check needs. Where that is missing, the check is skipped, and a line says why, unless it is required.
fn unless_missing<T>(
    check: &str,
    needed: Result<T>,
    is_required: bool,
    out: &mut impl std::io::Write,
) -> Result<Option<T>> {
    match needed {
        Err(why) if !is_required => {
            writeln!(out, "{check}: skipped, {why:#}")?;
            Ok(None)
        }
        needed => needed.map(Some),
    }
}

/// The workspace's own folder.
fn workspace() -> PathBuf {
    let xtask = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    xtask.parent().map(PathBuf::from).unwrap_or(xtask)
}

/// The folder of everything that is built.
fn target_folder() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| workspace().join("target"), PathBuf::from)
}

/// Builds the `fingervision` command as users do; returns its path.
fn build_command() -> Result<PathBuf> {
    let arguments = ["build", "--release", "--locked", "--quiet", "--package", "fingervision-cli"];
    expect_success(Command::new(env!("CARGO")).args(arguments).current_dir(workspace()))?;
    Ok(target_folder().join("release/fingervision"))
}

/// Runs a program to its end and returns its output.
fn expect_success(command: &mut Command) -> Result<Vec<u8>> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command.output().with_context(|| format!("{name} cannot be run"))?;
    ensure!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr).trim());
    Ok(output.stdout)
}

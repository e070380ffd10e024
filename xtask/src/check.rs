//! `cargo xtask check`: all checks except the tests.

use crate::{FEATURES, circles, layers, lengths, workspace};
use anyhow::{Context, Result, ensure};
use std::io::Write;
use std::process::Command;

pub(crate) fn run(out: &mut impl Write) -> Result<()> {
    lengths::run(out)?;
    layers::run(out)?;
    circles::run(out)?;
    cargo(&["fmt", "--all", "--check"], out)?;
    cargo(&["clippy", "--workspace", "--all-targets", FEATURES, "--locked", "--quiet", "--", "-D", "warnings"], out)?;
    // Without the features that are on by default.
    let core = ["clippy", "--package", "fingervision", "--no-default-features", "--locked", "--quiet"];
    cargo(&[&core[..], &["--", "-D", "warnings"]].concat(), out)?;
    // With the features of the first, so that no dependency is checked again.
    cargo(&["doc", "--workspace", FEATURES, "--no-deps", "--locked", "--quiet"], out)
}

fn cargo(arguments: &[&str], out: &mut impl Write) -> Result<()> {
    let mut command = Command::new(env!("CARGO"));
    command.args(arguments).current_dir(workspace()).env("RUSTDOCFLAGS", "-Dwarnings");
    let status = command.status().with_context(|| format!("cargo {}", arguments[0]))?;
    ensure!(status.success(), "cargo {} found faults", arguments[0]);
    writeln!(out, "{}: clean", arguments[0])?;
    Ok(())
}

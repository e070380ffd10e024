//! The wheels for other computers, built with Zig as linker and checked.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use super::{emulation, report};
use crate::environment::install;

/// The processors, as in the names of Rust's targets.
const PROCESSORS: [&str; 2] = ["x86_64", "aarch64"];
/// The oldest system: glibc 2.17.
const SYSTEM: &str = "manylinux2014";
/// The same in the words of auditwheel.
const POLICY: &str = "manylinux_2_17";
const TOOLS: [&str; 2] = ["ziglang>=0.13,<0.16", "auditwheel>=6.4,<7"];

/// Builds the wheels of all processors and returns that of this computer.
pub(super) fn build(tools: &Path, folder: &Path, out: &mut impl Write) -> Result<PathBuf> {
    ensure!(cfg!(target_os = "linux"), "the wheels are built on Linux");
    install(tools, &TOOLS)?;
    let mut own = None;
    for processor in PROCESSORS {
        let target = format!("{processor}-unknown-linux-gnu");
        expect_target(&target)?;
        let options = ["--release", "--zig", "--compatibility", SYSTEM, "--target", &target];
        let wheel = super::build(tools, &folder.join("wheels").join(processor), &options)?;
        report(&wheel, true, out)?;
        audit(tools, &wheel, processor, out)?;
        if processor == std::env::consts::ARCH {
            own = Some(wheel);
        } else if processor == emulation::PROCESSOR {
            emulation::test(tools, folder, &wheel, out)?;
        }
    }
    own.with_context(|| format!("there is no wheel for {}, which this computer has", std::env::consts::ARCH))
}

/// Fails if Rust's library for a target is not installed.
fn expect_target(target: &str) -> Result<()> {
    let printed = crate::expect_success(Command::new("rustc").args(["--print", "target-libdir", "--target", target]))?;
    let library = PathBuf::from(String::from_utf8_lossy(&printed).trim());
    ensure!(library.is_dir(), "Rust's library for {target} is missing: run `rustup target add {target}`");
    Ok(())
}

/// Has the symbols of a wheel's libraries compared with those of the oldest system.
fn audit(tools: &Path, wheel: &Path, processor: &str, out: &mut impl Write) -> Result<()> {
    let printed = crate::expect_success(Command::new(tools).args(["-m", "auditwheel", "show"]).arg(wheel))?;
    let verdict = String::from_utf8_lossy(&printed).split_whitespace().collect::<Vec<_>>().join(" ");
    let tag = format!("{POLICY}_{processor}");
    let is_consistent = verdict.contains(&format!("consistent with the following platform tag: \"{tag}\""));
    ensure!(is_consistent, "{} does not run on every system of {tag}: {verdict}", wheel.display());
    writeln!(out, "auditwheel: {tag}, {}", file_name(wheel))?;
    Ok(())
}

fn file_name(wheel: &Path) -> String {
    wheel.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// The folder of that name, empty.
pub(super) fn empty_folder(folder: &Path) -> Result<()> {
    if folder.exists() {
        fs::remove_dir_all(folder)?;
    }
    fs::create_dir_all(folder)?;
    Ok(())
}

//! `cargo xtask camera-test`: the camera crate's device tests, and the command with cameras, on a real kernel.
//!
//! A Debian kernel with test cameras boots in QEMU, without hardware and without root: vivid makes pictures itself, and
//! v4l2loopback sends what a program writes. Everything is downloaded as Debian packages and unpacked in the target
//! folder; nothing is installed. Where the packages cannot be downloaded, the tests are skipped, and a line says why.

mod guest;
mod packages;

use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::Command;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use serde::Deserialize;

use crate::FEATURES;
use packages::Packages;

/// A program is ended after this time, s; a boot with all tests takes half a minute.
const LONGEST_RUN_S: u32 = 600;

/// Options of the tests.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Fail instead of skipping the tests where packages are missing.
    #[arg(long)]
    required: bool,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<()> {
    let start = Instant::now();
    let folder = crate::target_folder().join("camera-test");
    fs::create_dir_all(&folder)?;
    let packages = Packages::get(&folder, out);
    let Some(packages) = crate::unless_missing("camera-test", packages, args.required, out)? else { return Ok(()) };
    let has_packages = start.elapsed();
    let [tests, command] = build()?;
    let is_built = start.elapsed();
    let initrd = guest::initrd(&folder, &packages, [&tests, &command])?;
    let log = guest::boot(&packages, &initrd, LONGEST_RUN_S)?;
    fs::write(folder.join("console.log"), &log)?;
    let text = String::from_utf8_lossy(&log);
    for line in text.lines().filter(|line| line.starts_with("test ")) {
        writeln!(out, "{}", line.trim_end())?;
    }
    let ends = [Duration::ZERO, has_packages, is_built, start.elapsed()];
    let [packages, build, guest] =
        [0, 1, 2].map(|part| format!("{:.0} s", ends[part + 1].saturating_sub(ends[part]).as_secs_f64()));
    writeln!(out, "camera-test: packages {packages}, build {build}, guest {guest}")?;
    if text.contains("GUEST: tests ended with 0 and 0") {
        return Ok(());
    }
    let shown: Vec<&str> = text.lines().skip_while(|line| !line.starts_with("running")).collect();
    bail!("the device tests failed; the console is in {}\n{}", folder.join("console.log").display(), shown.join("\n"))
}

#[derive(Debug, Deserialize)]
struct Message {
    executable: Option<PathBuf>,
    target: Option<Target>,
}

#[derive(Debug, Deserialize)]
struct Target {
    name: String,
}

/// Builds the tests and the command, as the tests of the whole workspace do: after these, nothing is left to build.
fn build() -> Result<[PathBuf; 2]> {
    let mut cargo = Command::new(env!("CARGO"));
    // The command is built for the tests that run it.
    cargo.args(["test", "--workspace", FEATURES, "--test", "devices", "--test", "command", "--no-run"]);
    cargo.args(["--locked", "--message-format", "json"]).current_dir(crate::workspace());
    let messages = crate::expect_success(&mut cargo)?;
    let messages = String::from_utf8_lossy(&messages).into_owned();
    let built: Vec<Message> = messages.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
    let program = |name: &str| {
        let is_wanted = |message: &&Message| message.target.as_ref().is_some_and(|target| target.name == name);
        let program = built.iter().filter(is_wanted).find_map(|message| message.executable.clone());
        program.with_context(|| format!("cargo built no {name}"))
    };
    Ok([program("devices")?, program("fingervision")?])
}

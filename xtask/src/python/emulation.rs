//! A wheel for aarch64, loaded in an emulated Python. Emulator and Python are Debian's, unpacked in the target folder.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use super::wheels::empty_folder;
use crate::expect_success;

/// The emulated processor.
pub(super) const PROCESSOR: &str = "aarch64";
/// Tracks an image and fails if the flow is wrong.
const FIRST_STEPS: &str = include_str!("first_steps.py");
/// What wheels may ask of the emulated system, which has a newer glibc.
const PLATFORMS: [&str; 2] = ["manylinux2014_aarch64", "manylinux_2_28_aarch64"];
/// Debian's packages for the emulated processor, in folders of their own.
const APT: &str = r#"APT::Architecture "arm64";
APT::Architectures { "arm64"; };
APT::Sandbox::User "root";
Dir::State "FOLDER/state";
Dir::State::status "FOLDER/state/status";
Dir::Cache "FOLDER/cache";
"#;

/// Loads a wheel and lets it measure a flow; says why if there is no emulator.
pub(super) fn test(tools: &Path, folder: &Path, wheel: &Path, out: &mut impl Write) -> Result<()> {
    let emulation = match Emulation::get(&folder.join("emulation")) {
        Ok(emulation) => emulation,
        Err(why) => {
            writeln!(out, "emulation: skipped, {why:#}")?;
            return Ok(());
        }
    };
    let packages = folder.join("emulation/packages");
    empty_folder(&packages)?;
    let mut pip = Command::new(tools);
    pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--only-binary=:all:", "--target"]);
    pip.arg(&packages).args(["--python-version", &emulation.version]);
    pip.args(PLATFORMS.iter().flat_map(|platform| ["--platform", platform])).arg(wheel);
    expect_success(&mut pip)?;
    let mut python = Command::new(&emulation.emulator);
    python.arg("-L").arg(&emulation.root).arg(emulation.root.join(format!("usr/bin/python{}", emulation.version)));
    let printed = expect_success(python.args(["-c", FIRST_STEPS]).env("PYTHONPATH", &packages))?;
    writeln!(out, "emulation: {}", String::from_utf8_lossy(&printed).trim())?;
    Ok(())
}

/// An emulator, and the system that it runs.
struct Emulation {
    emulator: PathBuf,
    root: PathBuf,
    /// Python's, as in `3.11`.
    version: String,
}

impl Emulation {
    /// Downloads and unpacks what is not there yet.
    fn get(folder: &Path) -> Result<Self> {
        let (host, root) = (folder.join("host"), folder.join("root"));
        let done = folder.join("done");
        if !done.is_file() {
            empty_folder(folder)?;
            let configuration = configure(folder)?;
            unpack(&["qemu-user-static".to_owned()], None, &host)?;
            let mut update = Command::new("apt-get");
            expect_success(update.args(["update", "--quiet"]).env("APT_CONFIG", &configuration))?;
            unpack(&needed_packages(&configuration)?, Some(&configuration), &root)?;
            fs::write(&done, "")?;
        }
        let python = root.join("usr/bin/python3");
        let linked = fs::read_link(&python).with_context(|| python.display().to_string())?;
        let name = linked.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let version = name.strip_prefix("python").context("Debian's python3 is no link to a version")?.to_owned();
        Ok(Self { emulator: host.join("usr/bin/qemu-aarch64-static"), root, version })
    }
}

/// Writes apt's configuration for the emulated processor, and the folders that it names.
fn configure(folder: &Path) -> Result<PathBuf> {
    for name in ["state/lists/partial", "cache/archives/partial"] {
        fs::create_dir_all(folder.join(name))?;
    }
    let folder = folder.canonicalize()?;
    fs::write(folder.join("state/status"), "")?;
    let configuration = folder.join("apt.conf");
    fs::write(&configuration, APT.replace("FOLDER", &folder.display().to_string()))?;
    Ok(configuration)
}

/// Python and all that it needs.
fn needed_packages(configuration: &Path) -> Result<Vec<String>> {
    let mut plan = Command::new("apt-get");
    plan.args(["install", "--simulate", "--no-install-recommends", "python3", "libstdc++6"]);
    let plan = expect_success(plan.env("APT_CONFIG", configuration))?;
    let plan = String::from_utf8_lossy(&plan).into_owned();
    Ok(plan.lines().filter_map(|line| Some(line.strip_prefix("Inst ")?.split(' ').next()?.to_owned())).collect())
}

/// Downloads packages and unpacks them into a folder.
fn unpack(packages: &[String], configuration: Option<&Path>, root: &Path) -> Result<()> {
    let archives = root.with_extension("archives");
    empty_folder(&archives)?;
    let mut download = Command::new("apt-get");
    download.args(["download", "--quiet"]).args(packages).current_dir(&archives);
    expect_success(download.envs(configuration.map(|path| ("APT_CONFIG", path))))?;
    for entry in fs::read_dir(&archives)? {
        expect_success(Command::new("dpkg").arg("--extract").arg(entry?.path()).arg(root))?;
    }
    fs::remove_dir_all(archives)?;
    // Newer packages keep all libraries in `usr/lib`.
    #[cfg(unix)]
    if !root.join("lib").exists() {
        std::os::unix::fs::symlink("usr/lib", root.join("lib"))?;
    }
    Ok(())
}

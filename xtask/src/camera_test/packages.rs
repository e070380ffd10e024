//! The Debian packages of the guest, unpacked, and the loopback module, compiled.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};

use crate::expect_success;

/// What is needed beside the kernel: the emulator with its firmware, and the guest's shell.
const PACKAGES: [&str; 5] = ["qemu-system-x86", "qemu-system-data", "seabios", "busybox-static", "v4l2loopback-dkms"];
/// Large packages that are not needed here.
const LEFT_OUT: [&str; 3] = ["dkms", "linux-libc-dev", "linux-perf"];

/// The unpacked packages.
#[derive(Debug)]
pub(super) struct Packages {
    /// The root of the unpacked files.
    pub(super) root: PathBuf,
    /// The kernel's version.
    pub(super) kernel: String,
    /// The compiled loopback module.
    pub(super) loopback: PathBuf,
}

impl Packages {
    /// Downloads, unpacks and compiles what is not there yet.
    pub(super) fn get(folder: &Path, out: &mut impl Write) -> Result<Self> {
        for program in ["apt-get", "apt-cache", "dpkg", "make", "gcc", "ldd", "gzip"] {
            let is_there = Command::new(program).arg("--version").output().is_ok();
            ensure!(is_there, "{program} is missing: the tests need a Debian system with a compiler");
        }
        ensure!(cfg!(target_arch = "x86_64"), "the emulated machine is an x86-64 one");
        let root = folder.join("root");
        let done = folder.join("kernel-version");
        let loopback = folder.join("v4l2loopback/v4l2loopback.ko");
        if let (Ok(kernel), true) = (fs::read_to_string(&done), loopback.is_file()) {
            return Ok(Self { root, kernel, loopback });
        }
        writeln!(out, "camera-test: downloading Linux and QEMU, about 115 MB")?;
        let kernel = match download_kernel(folder) {
            Ok(kernel) => kernel,
            // The system's list of packages is old or empty; only root can renew it.
            Err(why) if expect_success(Command::new("apt-get").arg("update")).is_err() => return Err(why),
            Err(_) => download_kernel(folder)?,
        };
        unpack(folder, &root)?;
        compile_loopback(folder, &root, &kernel)?;
        fs::write(done, &kernel)?;
        Ok(Self { root, kernel, loopback })
    }
}

/// Downloads the newest kernel and all other packages; returns the kernel's version.
fn download_kernel(folder: &Path) -> Result<String> {
    let image = kernel_package()?;
    let kernel = image.trim_start_matches("linux-image-").to_owned();
    download(folder, &image, &format!("linux-headers-{kernel}"))?;
    Ok(kernel)
}

/// The package of the newest kernel, as in `linux-image-6.1.0-56-amd64`.
fn kernel_package() -> Result<String> {
    let depends = expect_success(Command::new("apt-cache").args(["depends", "linux-image-amd64"]))?;
    let depends = String::from_utf8_lossy(&depends).into_owned();
    let names = depends.split_whitespace().map(str::to_owned);
    let mut kernels = names.filter(|name| name.starts_with("linux-image-") && name.contains('.'));
    kernels.next().context("this system's packages hold no linux-image-amd64; run apt-get update")
}

/// Downloads the packages and all that they need and that is not installed.
fn download(folder: &Path, image: &str, headers: &str) -> Result<()> {
    let archives = folder.join("archives");
    fs::create_dir_all(&archives)?;
    let mut plan = Command::new("apt-get");
    plan.args(["install", "--simulate", "--no-install-recommends", image, headers]);
    plan.args(PACKAGES.iter().filter(|name| **name != "v4l2loopback-dkms"));
    let plan = expect_success(&mut plan)?;
    let plan = String::from_utf8_lossy(&plan).into_owned();
    let listed = plan.lines().filter_map(|line| line.strip_prefix("Inst ")?.split(' ').next());
    let mut wanted: Vec<&str> = listed.filter(|name| !LEFT_OUT.contains(name)).collect();
    // Installed packages are not listed, but their files are needed below the folder.
    for package in PACKAGES.into_iter().chain([image, headers]) {
        if !wanted.contains(&package) {
            wanted.push(package);
        }
    }
    expect_success(Command::new("apt-get").arg("download").args(wanted).current_dir(&archives))?;
    Ok(())
}

fn unpack(folder: &Path, root: &Path) -> Result<()> {
    for entry in fs::read_dir(folder.join("archives"))? {
        let archive = entry?.path();
        if archive.extension().is_some_and(|extension| extension == "deb") {
            expect_success(Command::new("dpkg").arg("--extract").arg(&archive).arg(root))?;
        }
    }
    Ok(())
}

/// Compiles the module against the unpacked headers.
fn compile_loopback(folder: &Path, root: &Path, kernel: &str) -> Result<()> {
    let sources = root.join("usr/src");
    let headers = sources.join(format!("linux-headers-{kernel}"));
    // The headers name the folder in which they would be installed.
    let makefile = headers.join("Makefile");
    let text = fs::read_to_string(&makefile).with_context(|| makefile.display().to_string())?;
    let moved = format!("include {}", root.canonicalize()?.join("usr").display());
    fs::write(&makefile, text.replace("include /usr", &moved))?;
    let mut found = fs::read_dir(&sources)?.flatten().map(|entry| entry.path());
    let is_loopback =
        |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("v4l2loopback"));
    let Some(source) = found.find(is_loopback) else { bail!("the package of v4l2loopback holds no source") };
    let module = folder.join("v4l2loopback");
    fs::create_dir_all(&module)?;
    for entry in fs::read_dir(source)?.flatten() {
        if entry.path().is_file() {
            fs::copy(entry.path(), module.join(entry.file_name()))?;
        }
    }
    let built = format!("M={}", module.canonicalize()?.display());
    expect_success(Command::new("make").arg("-C").arg(&headers).args([built.as_str(), "modules"]))?;
    Ok(())
}

//! The guest: its files, and its boot.

use std::ffi::OsString;
use std::fs::{self, File};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};

use super::packages::Packages;
use crate::expect_success;

/// The first program of the guest.
const INIT: &str = include_str!("init.sh");
/// The emulated processor: the first with the instructions that every build needs (`.cargo/config.toml`).
const PROCESSOR: &str = "Nehalem";
/// Folders of kernel modules that the test cameras need, below `drivers/media`.
const MODULES: [&str; 6] = ["cec", "common", "mc", "rc", "v4l2-core", "test-drivers"];

/// Packs the guest's files: shell, kernel modules, the tests, the command, and the libraries that they use.
pub(super) fn initrd(folder: &Path, packages: &Packages, [tests, command]: [&Path; 2]) -> Result<PathBuf> {
    let Packages { root, kernel, loopback } = packages;
    let guest = folder.join("guest");
    if guest.exists() {
        fs::remove_dir_all(&guest)?;
    }
    fs::create_dir_all(guest.join("bin"))?;
    let busybox = root.join("bin/busybox");
    fs::copy(&busybox, guest.join("bin/busybox")).with_context(|| busybox.display().to_string())?;
    fs::copy(loopback, guest.join("v4l2loopback.ko"))?;
    fs::copy(tests, guest.join("devices"))?;
    fs::copy(command, guest.join("fingervision"))?;
    fs::write(guest.join("init"), INIT)?;
    fs::set_permissions(guest.join("init"), fs::Permissions::from_mode(0o755))?;
    let modules = Path::new("lib/modules").join(kernel);
    for name in MODULES {
        let media = modules.join("kernel/drivers/media").join(name);
        copy_folder(&root.join(&media), &guest.join(&media))?;
    }
    for list in ["modules.builtin", "modules.order"] {
        fs::copy(root.join(&modules).join(list), guest.join(&modules).join(list))?;
    }
    for library in [libraries(tests)?, libraries(command)?].concat() {
        let place = guest.join(library.strip_prefix("/").unwrap_or(&library));
        fs::create_dir_all(place.parent().unwrap_or(&guest))?;
        fs::copy(&library, place)?;
    }
    pack(&guest, &busybox.canonicalize()?, &folder.join("guest.cpio.gz"))
}

fn copy_folder(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from).with_context(|| from.display().to_string())? {
        let entry = entry?;
        let place = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            copy_folder(&entry.path(), &place)?;
        } else {
            fs::copy(entry.path(), place)?;
        }
    }
    Ok(())
}

/// The shared libraries of a program, with their paths.
fn libraries(program: &Path) -> Result<Vec<PathBuf>> {
    let listed = expect_success(Command::new("ldd").arg(program))?;
    let listed = String::from_utf8_lossy(&listed).into_owned();
    Ok(listed.split_whitespace().filter(|word| word.starts_with('/')).map(PathBuf::from).collect())
}

/// Packs a folder as the kernel reads it.
fn pack(guest: &Path, busybox: &Path, to: &Path) -> Result<PathBuf> {
    let script = r#"cd "$1" && find . | "$2" cpio -o -H newc | gzip -1 > "$3""#;
    let to = std::path::absolute(to)?;
    let mut shell = Command::new("sh");
    shell.args(["-c", script, "sh"]).args([guest, busybox, &to]);
    expect_success(&mut shell)?;
    Ok(to)
}

/// Boots the guest and returns what it wrote to its console.
pub(super) fn boot(packages: &Packages, initrd: &Path, longest_s: u32) -> Result<Vec<u8>> {
    let Packages { root, kernel, .. } = packages;
    let mut libraries = OsString::new();
    for folder in ["usr/lib/x86_64-linux-gnu", "lib/x86_64-linux-gnu", "usr/lib/x86_64-linux-gnu/pulseaudio"] {
        libraries.push(root.join(folder));
        libraries.push(":");
    }
    // `timeout` also ends a guest that hangs.
    let mut emulator = Command::new("timeout");
    emulator.arg(longest_s.to_string()).arg(root.join("usr/bin/qemu-system-x86_64"));
    emulator.args(["-accel", "tcg", "-cpu", PROCESSOR, "-m", "512", "-nographic", "-no-reboot", "-nic", "none"]);
    emulator.arg("-L").arg(root.join("usr/share/seabios")).arg("-L").arg(root.join("usr/share/qemu"));
    emulator.arg("-kernel").arg(root.join(format!("boot/vmlinuz-{kernel}"))).arg("-initrd").arg(initrd);
    emulator.args(["-append", "console=ttyS0 quiet panic=-1"]).env("LD_LIBRARY_PATH", libraries);
    let output = emulator.stdin(Stdio::from(File::open("/dev/null")?)).output().context("timeout cannot be run")?;
    let console = output.stdout;
    let errors = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "the emulator ended with {}: {}", output.status, errors.trim());
    Ok(console)
}

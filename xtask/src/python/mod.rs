//! `cargo xtask python`: builds the Python wheel and tests it in an environment of its own.
//!
//! Everything is installed in the target folder: `tools` has what builds the wheel, `testers` what tests it, and nothing
//! else of ours but the wheel. Both are kept for the next time. Where Python or its packages cannot be had, the tests are
//! skipped, and a line says why. With `--wheels` the wheels for other computers are built and checked, too.

mod emulation;
pub(crate) mod module;
mod wheels;

use std::env;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::environment::{Interpreter, is_installed, replace};

/// What a released wheel may have, bytes.
const LARGEST_WHEEL: u64 = 15_000_000;
const DEVELOPMENT: &str = "dev";
const MATURIN: &str = "maturin>=1.9,<2";
/// The examples that need a library of their own, which `--with` installs.
const WITH_LIBRARIES: [(&str, &str); 3] =
    [("dataset.py", "ray"), ("rerun_stream.py", "rerun"), ("torch_loop.py", "torch")];
const TESTERS: [&str; 8] = [
    "pytest>=8",
    "mypy>=1.14",
    "pyright[nodejs]>=1.1.390",
    "matplotlib>=3.8",
    "pillow>=9.4",
    "pyarrow>=14",
    "setuptools>=70.1",
    "draccus==0.10.0",
];
/// The classes of cameras need only draccus of all that LeRobot needs, among it `PyTorch`.
const LEROBOT: &str = "lerobot==0.4.4";
const LEROBOT_CAMERA: &str = "lerobot_camera_fingervision";

/// Options of the tests.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Fail instead of skipping the tests where Python or packages are missing.
    #[arg(long)]
    required: bool,
    /// Test a wheel of the development profile, which checks for overflow and is slower.
    #[arg(long)]
    dev: bool,
    /// Build the wheels for other computers: x86-64 and aarch64, Linux with glibc 2.17 or later.
    #[arg(long, conflicts_with = "dev")]
    wheels: bool,
    /// Install this package too, for an example or a test: `lerobot`, `ray`, `rerun-sdk` or `torch`; may be repeated.
    #[arg(long, value_name = "PACKAGE")]
    with: Vec<String>,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<()> {
    let folder = crate::target_folder().join("python");
    fs::create_dir_all(&folder)?;
    let needed = environments(&folder, &args.with);
    let Some((tools, testers)) = crate::unless_missing("python", needed, args.required, out)? else { return Ok(()) };
    let wheel = if args.wheels {
        wheels::build(&tools, &folder, out)?
    } else {
        let options: &[&str] = if args.dev { &["--profile", DEVELOPMENT] } else { &["--release"] };
        let wheel = build(&tools, &folder.join("wheels"), options)?;
        report(&wheel, !args.dev, out)?;
        wheel
    };
    replace(&testers, "fingervision", &wheel, &[])?;
    install_camera(&testers, &folder)?;
    test(&testers, out)
}

/// The interpreters of `tools` and `testers`.
fn environments(folder: &Path, with: &[String]) -> Result<(PathBuf, PathBuf)> {
    let python = Interpreter::find()?;
    let testers: Vec<&str> = TESTERS.into_iter().chain(with.iter().map(String::as_str)).collect();
    let bare: &[&str] = if with.iter().any(|package| package.starts_with("lerobot")) { &[] } else { &[LEROBOT] };
    let tools = python.environment(&folder.join("tools"), &[MATURIN], &[])?;
    Ok((tools, python.environment(&folder.join("testers"), &testers, bare)?))
}

/// Builds a wheel into a folder that has no other one.
fn build(tools: &Path, wheels: &Path, options: &[&str]) -> Result<PathBuf> {
    if wheels.exists() {
        fs::remove_dir_all(wheels)?;
    }
    let mut maturin = Command::new(tools);
    // Zig is a package beside maturin, which looks for it with the first interpreter of the path.
    let path = env::var_os("PATH").unwrap_or_default();
    let beside = tools.parent().map(Path::to_path_buf).into_iter().chain(env::split_paths(&path));
    maturin.env("PATH", env::join_paths(beside)?);
    maturin.args(["-m", "maturin", "build", "--locked", "--out"]).arg(wheels).args(options);
    if options.contains(&DEVELOPMENT) {
        module::instead_of_cargo(&mut maturin)?;
    }
    crate::expect_success(maturin.current_dir(crate::workspace().join("python")))?;
    let mut found = fs::read_dir(wheels)?.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>>>()?;
    found.pop().with_context(|| format!("maturin built no wheel in {}", wheels.display()))
}

/// Prints the size of a wheel; a released one may not be too large.
fn report(wheel: &Path, is_released: bool, out: &mut impl Write) -> Result<()> {
    let bytes = fs::metadata(wheel)?.len();
    let name = wheel.file_name().unwrap_or_default().display();
    writeln!(out, "python: {name}, {:.1} MB", bytes as f64 / 1e6)?;
    ensure!(!is_released || bytes <= LARGEST_WHEEL, "{name} has {bytes} bytes, and {LARGEST_WHEEL} are allowed");
    Ok(())
}

/// Installs sensors as cameras of LeRobot from a copy, because setuptools writes into the folder that it builds.
fn install_camera(testers: &Path, folder: &Path) -> Result<()> {
    let source = crate::workspace().join("python").join(LEROBOT_CAMERA);
    let copy = folder.join(LEROBOT_CAMERA);
    wheels::empty_folder(&copy.join(LEROBOT_CAMERA))?;
    for part in [&source, &source.join(LEROBOT_CAMERA)] {
        for entry in fs::read_dir(part)? {
            let path = entry?.path();
            if path.is_file() {
                let name = path.strip_prefix(&source)?;
                fs::copy(&path, copy.join(name)).with_context(|| path.display().to_string())?;
            }
        }
    }
    replace(testers, LEROBOT_CAMERA, &copy, &["--no-deps", "--no-build-isolation"])
}

/// Compares the stubs with the module, checks all types, and runs the tests and the examples.
fn test(python: &Path, out: &mut impl Write) -> Result<()> {
    let interpreter = python.display().to_string();
    let examples = typed_examples(python, out)?;
    let pyright = ["-m", "pyright", "--pythonpath", &interpreter, "package", "tests", "stub_docs.py"];
    let pyright: Vec<&str> = pyright.into_iter().chain(examples.iter().map(String::as_str)).collect();
    let pytest = ["-m", "pytest", "--quiet", "-rs", "-p", "no:cacheprovider"];
    let chores: [(&str, &str, &[&str]); 5] = [
        ("documentation of the stubs", "", &["stub_docs.py", "--check"]),
        ("stubtest", "", &["-m", "mypy.stubtest", "fingervision._native", "--concise"]),
        ("pyright", "", &pyright),
        ("pytest", "", &pytest),
        ("pytest of the LeRobot camera", LEROBOT_CAMERA, &pytest),
    ];
    for (name, folder, arguments) in chores {
        let mut chore = Command::new(python);
        let folder = crate::workspace().join("python").join(folder);
        chore.args(arguments).env("PYTHONDONTWRITEBYTECODE", "1").current_dir(folder);
        let status = chore.status().with_context(|| format!("{name} cannot be run"))?;
        ensure!(status.success(), "{name} found faults");
        writeln!(out, "{name}: clean")?;
    }
    Ok(())
}

/// The examples whose types can be checked: those whose library is installed.
fn typed_examples(python: &Path, out: &mut impl Write) -> Result<Vec<String>> {
    let mut examples = Vec::new();
    for entry in fs::read_dir(crate::workspace().join("python/examples"))? {
        let path = entry?.path();
        if path.extension().is_none_or(|extension| extension != "py") {
            continue;
        }
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let needed = WITH_LIBRARIES.iter().find(|(example, _)| *example == name);
        if let Some((_, library)) = needed
            && !is_installed(python, library)?
        {
            writeln!(out, "pyright: {name} is skipped, {library} is not installed")?;
        } else {
            examples.push(format!("examples/{name}"));
        }
    }
    examples.sort();
    Ok(examples)
}

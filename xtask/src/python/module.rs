//! The extension module in the development profile, made of the libraries that the workspace's tests use.
//!
//! Cargo selects the features of a library by what is built together with it. maturin has the package built alone, for
//! which nearly all libraries would be compiled a second time. Instead it calls this program in the place of cargo, and
//! this builds the libraries of the whole workspace with the features of its tests. Only `pyo3` and the package itself are
//! then left to compile.

use std::env;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::{FEATURES, workspace};

/// A small test. Only if a test is built, too, the features that tests need are selected.
const TEST: &str = "plans";
/// Variables by which maturin passes one interpreter to `pyo3`. They are removed: the module is for all interpreters, and with
/// them `pyo3` would be compiled again after `cargo xtask check`.
const INTERPRETER: [&str; 4] =
    ["PYO3_CONFIG_FILE", "PYO3_ENVIRONMENT_SIGNATURE", "PYO3_PYTHON", "PYTHON_SYS_EXECUTABLE"];

/// What maturin asks of cargo: the package's library, and messages in JSON.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    arguments: Vec<String>,
}

/// Has `maturin build` call this program in the place of cargo.
pub(super) fn instead_of_cargo(maturin: &mut Command) -> Result<()> {
    maturin.env("CARGO", env::current_exe()?);
    Ok(())
}

/// Builds the module; the messages that maturin reads are printed.
pub(crate) fn run(args: &Args) -> Result<()> {
    let asked = args.arguments.join(" ");
    ensure!(asked.contains("--profile dev"), "maturin asks for another profile than dev: cargo rustc {asked}");
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["build", "--workspace", FEATURES, "--locked", "--lib", "--test", TEST]);
    cargo.args(["--message-format", "json-render-diagnostics"]);
    for name in INTERPRETER {
        cargo.env_remove(name);
    }
    let status = cargo.current_dir(workspace()).status().context("cargo cannot be run")?;
    ensure!(status.success(), "cargo could not build the module");
    Ok(())
}

//! The `fingervision` command: glue between the libraries and the person at the keyboard, a file per subcommand.
//!
//! Data goes to standard output, messages to standard error. Exit codes: 0 done, 1 failed with one `error:` line and
//! where possible a `hint:`, 2 wrong usage. A reader that closes the pipe early is no failure.

mod bench;
mod calibrate;
mod demo;
mod doctor;
mod evaluate;
mod failure;
mod interrupt;
mod output;
mod pattern;
mod profile_args;
mod report_folder;
mod reproduce;
mod run_record;
mod scene_args;
mod simulate;
mod simulated_press;
mod simulation_run;
mod summary;
mod track;
mod tracking;
mod truth;

use std::io::{self, Write};
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use failure::Failure;

/// Camera-based touch: from images of a patterned gel to flow, depth and force.
#[derive(Debug, Parser)]
#[command(name = "fingervision", version, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Track(track::Args),
    Simulate(simulate::Args),
    Evaluate(evaluate::Args),
    Reproduce(reproduce::Args),
    Demo(demo::Args),
    Pattern(pattern::Args),
    Calibrate(calibrate::Args),
    Bench(bench::Args),
    Doctor(doctor::Args),
}

impl Command {
    fn run(&self, out: &mut impl Write) -> Result<(), Failure> {
        match self {
            Self::Track(args) => track::run(args, out)?,
            Self::Simulate(args) => simulate::run(args, out)?,
            Self::Evaluate(args) => evaluate::run(args, out)?,
            Self::Reproduce(args) => reproduce::run(args, out)?,
            Self::Demo(args) => demo::run(args, out)?,
            Self::Pattern(args) => pattern::run(args, out)?,
            Self::Calibrate(args) => calibrate::run(args, out)?,
            Self::Bench(args) => bench::run(args, out)?,
            Self::Doctor(args) => doctor::run(args, out)?,
        }
        Ok(out.flush()?)
    }
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    match cli.command.run(&mut io::stdout().lock()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(&mut io::stderr().lock()),
    }
}

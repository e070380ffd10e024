//! The `fingervision` command: glue between the libraries and the user, a file per subcommand.
//!
//! Data goes to standard output, messages to standard error. Exit codes: 0 done, 1 failed with one `error:` line and,
//! if possible, a `hint:`, 2 wrong usage, 130 ended by Ctrl-C and 143 by SIGTERM. A reader that closes the pipe early
//! is not an error. With `--json` every message is a JSON object on its own line, `{"error", "hint", "exit_code"}` or
//! `{"note"}`.
//!
//! [`run`] is the whole program, for those who start it from another language.

mod bench;
mod calibrate;
mod demo;
mod disk;
mod doctor;
mod evaluate;
mod export;
mod failure;
mod fingerprint;
mod interrupt;
mod live;
mod output;
mod part;
mod pattern;
mod place;
mod profile;
mod profile_args;
mod reader;
mod record;
mod recording_file;
mod report_folder;
mod reproduce;
mod run_record;
mod scene_args;
mod shell;
mod simulate;
mod simulated_press;
mod simulation_run;
mod skipped;
mod summary;
mod threads;
mod track;
mod tracking;
mod truth;
mod unfinished;
mod whole_number;
mod writer;

use std::ffi::OsString;
use std::io::{self, Write};

use clap::{ArgAction, CommandFactory, FromArgMatches, Parser, Subcommand};

use failure::{Failure, Wording};
pub use place::Place;
pub use tracking::fields_to_compute;

/// The exit code of wrong usage.
const WRONG_USAGE: u8 = 2;

/// The first commands to try.
const NEXT_STEPS: &str = "\
Start:
  fingervision demo                        simulated presses on a page, no hardware needed
  fingervision doctor                      check this machine
  fingervision profile new --out s.toml    describe your sensor, then: fingervision calibrate
  fingervision live --profile s.toml       show what your sensor measures
  fingervision track RECORDING --out run   track a folder of images or a video
`fingervision COMMAND --help` explains a command.";

/// Camera-based touch: from images of a patterned gel to flow, depth and force.
#[derive(Debug, Parser)]
#[command(name = "fingervision", version, arg_required_else_help = true, after_help = NEXT_STEPS)]
pub(crate) struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    threads: threads::ThreadArgs,
}

#[derive(Debug, Subcommand)]
enum Command {
    Live(live::Args),
    Record(record::Args),
    Track(track::Args),
    Simulate(simulate::Args),
    Evaluate(evaluate::Args),
    Export(export::Args),
    Reproduce(reproduce::Args),
    Demo(demo::Args),
    Pattern(pattern::Args),
    Profile(profile::Args),
    Calibrate(calibrate::Args),
    Bench(bench::Args),
    Doctor(doctor::Args),
    Completions(shell::CompletionsArgs),
    Man(shell::ManArgs),
}

impl Command {
    fn run(&self, out: &mut impl Write) -> Result<(), Failure> {
        match self {
            Self::Live(args) => live::run(args, out)?,
            Self::Record(args) => record::run(args, out)?,
            Self::Track(args) => track::run(args, out)?,
            Self::Simulate(args) => simulate::run(args, out)?,
            Self::Evaluate(args) => evaluate::run(args, out)?,
            Self::Export(args) => export::run(args, out)?,
            Self::Reproduce(args) => reproduce::run(args, out)?,
            Self::Demo(args) => demo::run(args, out)?,
            Self::Pattern(args) => pattern::run(args, out)?,
            Self::Profile(args) => profile::run(args, out)?,
            Self::Calibrate(args) => calibrate::run(args, out)?,
            Self::Bench(args) => bench::run(args, out)?,
            Self::Doctor(args) => doctor::run(args, out)?,
            Self::Completions(args) => shell::completions(args, out)?,
            Self::Man(args) => shell::man(args, out)?,
        }
        Ok(out.flush()?)
    }
}

/// Runs the program and returns its exit code. The first argument is the program's name.
///
/// Takes over signals, prints to standard output and standard error, and ends the process itself after a signal, after
/// wrong usage, and after `--help`.
#[must_use]
pub fn run(arguments: &[OsString]) -> u8 {
    let is_json = arguments.iter().take_while(|argument| *argument != "--").any(|argument| argument == "--json");
    let wording = if is_json { Wording::Json } else { Wording::Text };
    let cli = match parse(arguments) {
        Ok(cli) => cli,
        Err(error) if is_json && error.use_stderr() => return wrong_usage(&error),
        Err(error) => error.exit(),
    };
    let done = watch_for_signals(wording)
        .and_then(|()| expect_text(wording, arguments))
        .and_then(|()| cli.threads.apply())
        .and_then(|()| cli.command.run(&mut io::stdout().lock()));
    done.map_or_else(|failure| failure.report(wording, &mut io::stderr().lock()), |()| 0)
}

fn parse(arguments: &[OsString]) -> Result<Cli, clap::Error> {
    let mut command = takes_negative_numbers(Cli::command());
    let matches = command.try_get_matches_from_mut(arguments)?;
    Cli::from_arg_matches(&matches).map_err(|error| error.format(&mut command))
}

/// The command, with options that take a negative number as their value. They refuse it and name the expected value,
/// instead of reporting an unknown option.
fn takes_negative_numbers(command: clap::Command) -> clap::Command {
    let command = command.mut_args(|arg| {
        let takes_value = matches!(arg.get_action(), ArgAction::Set | ArgAction::Append);
        let is_option = arg.get_long().is_some() && takes_value;
        if is_option { arg.allow_negative_numbers(true) } else { arg }
    });
    command.mut_subcommands(takes_negative_numbers)
}

/// From here on, a signal ends the command, which first reports the interruption.
fn watch_for_signals(wording: Wording) -> Result<(), Failure> {
    let report_interruption = move || {
        let failure = Failure::new("interrupted before the result was written", "run the command again");
        failure.report(wording, &mut io::stderr().lock());
    };
    interrupt::watch(report_interruption).map_err(|error| {
        let hint = "start the command from a shell, where signals reach it";
        Failure::new(format!("cannot listen to Ctrl-C: {error}"), hint)
    })
}

/// Wrong usage, for a program: clap's first line, and the rest of its message as the hint.
fn wrong_usage(error: &clap::Error) -> u8 {
    let text = error.to_string();
    let (message, rest) = text.split_once('\n').unwrap_or((&text, ""));
    let hint = rest.lines().map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ");
    let message = message.trim_start_matches("error: ");
    // Without standard error there is no one to inform.
    let _ = Wording::Json.error(message, Some(&hint), WRONG_USAGE, &mut io::stderr().lock());
    WRONG_USAGE
}

/// JSON contains only text: refuses, before any work, names that could not be written in the result.
fn expect_text(wording: Wording, arguments: &[OsString]) -> Result<(), Failure> {
    let odd = arguments.iter().skip(1).find(|argument| argument.to_str().is_none());
    match odd.filter(|_| wording == Wording::Json) {
        Some(odd) => Err(Failure::new(
            format!("{} is not UTF-8 text, which --json needs", odd.display()),
            "rename the file or folder, or leave --json out",
        )),
        None => Ok(()),
    }
}

//! `fingervision profile`: starts, shows, checks and completes the file that describes a sensor.

mod check;
mod fingerprint;
mod known;
mod new;
mod show;
mod template;

use std::io::Write;

use clap::Subcommand;

use crate::failure::Failure;

/// Start, show, check or complete a profile, the file that describes one sensor
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    task: Task,
}

#[derive(Debug, Subcommand)]
enum Task {
    New(new::Args),
    Show(show::Args),
    Check(check::Args),
    Fingerprint(fingerprint::Args),
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    match &args.task {
        Task::New(args) => new::run(args, out),
        Task::Show(args) => show::run(args, out),
        Task::Check(args) => check::run(args, out),
        Task::Fingerprint(args) => fingerprint::run(args, out),
    }
}

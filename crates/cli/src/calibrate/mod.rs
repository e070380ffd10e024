//! `fingervision calibrate`: from recordings of known motion to a sensor's profile.

mod camera;
mod depth;

use std::io::Write;

use clap::Subcommand;

use crate::failure::Failure;

/// Calibrate a sensor: fit a part of its profile to recordings of known motion
#[derive(Debug, clap::Args)]
#[command(arg_required_else_help = true)]
pub(crate) struct Args {
    #[command(subcommand)]
    part: Part,
}

/// What is fitted.
#[derive(Debug, Subcommand)]
enum Part {
    Camera(camera::Args),
    Depth(depth::Args),
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    match &args.part {
        Part::Camera(args) => camera::run(args, out),
        Part::Depth(args) => depth::run(args, out),
    }
}

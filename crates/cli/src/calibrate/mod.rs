//! `fingervision calibrate`: from recordings of known motion to a sensor's profile.

mod camera;
mod depth;
mod gel;
mod guide;
mod press;

use std::io::Write;

use clap::Subcommand;

use crate::failure::Failure;

/// Calibrate a sensor: be led through it, or fit one part of its profile to recordings of known motion
///
/// Without a subcommand it leads through the calibration of a real sensor. A folder holds the recordings: the untouched gel, a
/// sliding board, some presses. It says which is next and how to take it, checks each as it comes, says what to do again and
/// why, and at last writes the sensor's profile. Run it again after every recording.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(crate) struct Args {
    #[command(subcommand)]
    part: Option<Part>,
    #[command(flatten)]
    guide: guide::GuideArgs,
}

/// What is fitted.
#[derive(Debug, Subcommand)]
enum Part {
    Camera(camera::Args),
    Depth(depth::Args),
    Gel(gel::Args),
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    match &args.part {
        Some(Part::Camera(args)) => camera::run(args, out),
        Some(Part::Depth(args)) => depth::run(args, out),
        Some(Part::Gel(args)) => gel::run(args, out),
        None => guide::run(&args.guide, out),
    }
}

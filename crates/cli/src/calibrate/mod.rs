//! `fingervision calibrate`: fits a sensor's profile to recordings of known motion.

mod camera;
mod depth;
mod gel;
mod guide;
mod press;
mod repeated;

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Subcommand;
use fingervision_calibrate::load_to_update;
use fingervision_touch::Profile;

use crate::failure::Failure;

/// Calibrate a sensor: a guided calibration, or the fit of one part of its profile to recordings of known motion
///
/// Without a subcommand it guides through the calibration of a real sensor. A folder contains the recordings: the
/// untouched gel, a sliding board, some presses. The command explains which one is next and how to take it, checks each
/// one when it is there, says which ones to repeat and why, and finally writes the sensor's profile. Run it again after
/// every recording.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(crate) struct Args {
    #[command(subcommand)]
    part: Option<Part>,
    #[command(flatten)]
    guide: guide::GuideArgs,
}

/// The parts that can be fitted.
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

/// The profile of a sensor that is to be calibrated further.
fn load(path: &Path) -> Result<Profile, Failure> {
    load_to_update(path).map_err(|error| {
        let begin_one = format!("start one: fingervision profile new --out {}", path.display());
        let hint = if path.exists() { error.hint() } else { Some(begin_one) };
        Failure::Stated { message: error.to_string(), hint }
    })
}

/// A picture beside a file: its name without the extension, then the picture's subject.
fn beside(file: &Path, shown: &str) -> PathBuf {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    file.with_file_name(format!("{stem}-{shown}.png"))
}

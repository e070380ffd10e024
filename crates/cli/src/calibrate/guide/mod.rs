//! `fingervision calibrate` alone: through the calibration of a real sensor, a recording at a time.

mod answers;
mod finish;
mod look;
mod words;

use std::fs;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};

use fingervision_calibrate::camera::Prior;
use serde::Serialize;

use crate::failure::Failure;
use crate::output::OutputArgs;

use super::camera::{direction, positive};
use answers::Answers;
use finish::{Outcome, calibrate};
use look::{State, Step, look};

/// The sensor's profile in its folder.
const PROFILE: &str = "sensor.toml";

#[derive(Debug, clap::Args)]
pub(crate) struct GuideArgs {
    /// The folder of the sensor: it takes the recordings, the answers to what is asked, and at last the profile
    #[arg(long, value_name = "DIR", default_value = "fingervision-sensor")]
    folder: PathBuf,
    /// How far the board moves between neighbouring images, mm; 0.5 until told otherwise, then kept in the folder
    #[arg(long, value_name = "MM", value_parser = positive)]
    step_mm: Option<f64>,
    /// Where the board goes in the image: x, y, or degrees from x towards y; x until told otherwise, then kept
    #[arg(long, value_name = "x|y|DEG", value_parser = direction, allow_negative_numbers = true)]
    direction: Option<f64>,
    /// The distance from the lens to the gel's surface as you measured it, as in 25±0.5 or 25+-0.5; kept
    #[arg(long, value_name = "MM±SD", value_parser = distance)]
    distance_mm: Option<Prior>,
    #[command(flatten)]
    output: OutputArgs,
}

/// How far the calibration is.
#[derive(Debug, Serialize)]
struct Progress<'a> {
    folder: &'a Path,
    steps: Vec<Step>,
    /// Once all steps are done.
    #[serde(flatten)]
    outcome: Option<Outcome>,
}

pub(crate) fn run(args: &GuideArgs, out: &mut impl Write) -> Result<(), Failure> {
    let answers = Answers::load(&args.folder)?.with(args.step_mm, args.direction, args.distance_mm);
    let is_attended = io::stdin().is_terminal() && io::stdout().is_terminal() && !args.output.is_json();
    loop {
        let progress = Progress::new(args, &answers)?;
        args.output.result(out, &progress, &progress.to_string())?;
        let redo = progress.steps.iter().find_map(Step::fault);
        if progress.outcome.is_some() {
            return Ok(());
        }
        if !is_attended {
            return redo.map_or(Ok(()), Err);
        }
        writeln!(out, "\nEnter looks again, Ctrl-C ends.")?;
        out.flush()?;
        if io::stdin().read_line(&mut String::new())? == 0 {
            return Ok(());
        }
    }
}

impl<'a> Progress<'a> {
    /// Looks at the folder, makes room for what comes next, and calibrates once all is there.
    fn new(args: &'a GuideArgs, answers: &Answers) -> Result<Self, Failure> {
        let folder = args.folder.as_path();
        let steps = look(folder, answers, args.output)?;
        if let Some(place) = steps.iter().find(|step| step.state == State::Next).and_then(|step| step.folder.as_ref()) {
            make(place)?;
        }
        make(folder)?;
        answers.save(folder)?;
        let is_complete = steps.iter().all(|step| step.state == State::Done);
        let outcome = if is_complete { Some(calibrate(folder, answers, &steps, args.output)?) } else { None };
        Ok(Self { folder, steps, outcome })
    }
}

fn make(folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(|error| {
        let message = format!("{}: cannot be made: {}", folder.display(), error.kind());
        Failure::new(message, "name a folder that you may write with --folder")
    })
}

/// A measured distance, mm.
fn distance(text: &str) -> Result<Prior, String> {
    let form = |_| "it takes the distance and how far it may be off, above 0 mm, as in 25±0.5 or 25+-0.5".to_string();
    Prior::parse(&format!("distance_mm={text}")).map(|(_, prior)| prior).map_err(form)
}

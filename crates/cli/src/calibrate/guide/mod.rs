//! `fingervision calibrate` alone: through the calibration of a real sensor, a recording at a time.

mod answers;
mod checks;
mod finish;
mod look;
mod words;

use std::fs;
use std::io::{self, BufRead, IsTerminal, Write};
use std::path::{Path, PathBuf};

use fingervision_calibrate::camera::Prior;
use serde::Serialize;

use crate::failure::Failure;
use crate::output::OutputArgs;

use super::camera::{direction, positive};
use answers::{Answers, Given};
use finish::{Outcome, calibrate};
use look::{Kind, State, Step, look};

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
    /// How much of the gel's surface the image shows from its left border to its right one, mm, as a ruler on the gel shows it: the camera is checked against it; kept
    #[arg(long, value_name = "MM", value_parser = length)]
    view_mm: Option<f64>,
    /// The gel's width, height and thickness, mm, as in 30,30,10: with it depth, contact and force come from elasticity; kept
    #[arg(long, value_name = "W,H,T", value_parser = gel)]
    gel_mm: Option<Gel>,
    /// The gel's Young's modulus, `MPa`, if it is known: force needs it, or a column `force_z_n` in the presses' depth.csv; kept
    #[arg(long, value_name = "MPA", value_parser = modulus)]
    youngs_modulus_mpa: Option<f64>,
    #[command(flatten)]
    output: OutputArgs,
}

/// Width, height and thickness, mm.
type Gel = [f64; 3];

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
    let given = Given {
        step_mm: args.step_mm,
        direction_deg: args.direction,
        distance: args.distance_mm,
        view_mm: args.view_mm,
        gel_mm: args.gel_mm,
        youngs_modulus_mpa: args.youngs_modulus_mpa,
    };
    let mut answers = Answers::load(&args.folder)?.with(&given);
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
        let next = progress.steps.iter().find(|step| step.is_open()).map(|step| step.kind);
        let Some(heard) = hear(next, &mut io::stdin().lock(), out)? else { return Ok(()) };
        answers = answers.with(&heard);
    }
}

/// Waits for a line: an answer to what is asked for, or an empty one. What is no answer is asked for again; none at the end
/// of the input.
fn hear(next: Option<Kind>, lines: &mut impl BufRead, out: &mut impl Write) -> Result<Option<Given>, Failure> {
    let asked = if next == Some(Kind::Distance) {
        "The distance in mm, as in 25±0.5, then Enter"
    } else {
        "Enter looks again"
    };
    loop {
        writeln!(out, "\n{asked}; Ctrl-C ends.")?;
        out.flush()?;
        let mut line = String::new();
        if lines.read_line(&mut line)? == 0 {
            return Ok(None);
        }
        match (next, line.trim()) {
            (_, "") => return Ok(Some(Given::default())),
            (Some(Kind::Distance), text) => match distance(text) {
                Ok(distance) => return Ok(Some(Given { distance: Some(distance), ..Given::default() })),
                Err(form) => writeln!(out, "{text} is no distance: {form}")?,
            },
            (_, text) => writeln!(out, "nothing is asked for that {text} could answer")?,
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
        let is_complete = !steps.iter().any(Step::is_open);
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

/// A length, mm.
fn length(text: &str) -> Result<f64, String> {
    let length = text.trim().parse().ok().filter(|value| (0.1..=1000.0).contains(value));
    length.ok_or_else(|| "it takes a length in mm, 0.1 to 1000".into())
}

/// The gel's width, height and thickness, mm.
fn gel(text: &str) -> Result<Gel, String> {
    let lengths: Result<Vec<f64>, String> = text.split(',').map(length).collect();
    let lengths = lengths.ok().and_then(|lengths| Gel::try_from(lengths).ok());
    lengths.ok_or_else(|| "it takes width, height and thickness in mm, as in 30,30,10".into())
}

/// A stiffness, `MPa`.
fn modulus(text: &str) -> Result<f64, String> {
    let modulus = text.trim().parse().ok().filter(|value: &f64| *value > 0.0 && *value <= 1e4);
    modulus.ok_or_else(|| "it takes a stiffness in MPa above 0, as in 0.6 for soft silicone".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heard(next: Kind, typed: &str) -> (Option<Given>, String) {
        let mut said = Vec::new();
        let heard = hear(Some(next), &mut typed.as_bytes(), &mut said).unwrap();
        (heard, String::from_utf8(said).unwrap())
    }

    #[test]
    fn a_distance_that_is_typed_is_taken() {
        let (given, said) = heard(Kind::Distance, "far\n25±0.5\n");
        assert_eq!(given.unwrap().distance, Some(Prior { value: 25.0, deviation: 0.5 }));
        assert!(said.contains("far is no distance: it takes"), "{said}");
    }

    #[test]
    fn an_empty_line_looks_again_and_the_end_of_the_input_ends() {
        assert!(heard(Kind::Board, "\n").0.unwrap().distance.is_none());
        assert!(heard(Kind::Board, "").0.is_none());
        assert!(heard(Kind::Board, "25±0.5\n").1.contains("nothing is asked for that 25±0.5 could answer"));
    }

    #[test]
    fn a_gel_is_three_lengths() {
        assert_eq!(gel("30, 30,10"), Ok([30.0, 30.0, 10.0]));
        assert!(gel("30,30").is_err() && gel("30,30,0").is_err() && gel("30,30,10000").is_err());
    }
}

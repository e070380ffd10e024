//! `fingervision calibrate` alone: guides through the calibration of a real sensor, one recording after another.

mod answers;
mod checks;
mod finish;
mod lines;
mod live_camera;
mod look;
mod shoot;
mod words;

use std::fs;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};

use fingervision_calibrate::camera::Prior;
use serde::Serialize;

use fingervision_image::Rect;
use fingervision_touch::Profile;

use crate::failure::Failure;
use crate::live::PageArgs;
use crate::output::OutputArgs;

use super::camera::{direction, positive};
use answers::{Answers, Given};
use finish::{Outcome, calibrate};
use lines::Lines;
use live_camera::LiveCamera;
use look::{Kind, State, Step, look};
use shoot::Shoot;

/// The sensor's profile in its folder.
const PROFILE: &str = "sensor.toml";

#[derive(Debug, clap::Args)]
pub(crate) struct GuideArgs {
    /// The folder of the sensor: it contains the recordings, the answers and finally the profile
    #[arg(long, value_name = "DIR", default_value = "fingervision-sensor")]
    folder: PathBuf,
    /// Step of the board between consecutive images, mm; 0.5 if not given; stored in the folder
    #[arg(long, value_name = "MM", value_parser = positive)]
    step_mm: Option<f64>,
    /// Direction of the board in the image: x, y, or degrees from x towards y; x if not given; stored
    #[arg(long, value_name = "x|y|DEG", value_parser = direction, allow_negative_numbers = true)]
    direction: Option<f64>,
    /// The measured distance from the lens to the gel's surface, as in 25±0.5 or 25+-0.5; stored
    #[arg(long, value_name = "MM±SD", value_parser = distance)]
    distance_mm: Option<Prior>,
    /// Width of the gel's surface between the image's left and right border, mm, measured with a ruler on the gel; the
    /// camera is checked against it; stored
    #[arg(long, value_name = "MM", value_parser = length)]
    view_mm: Option<f64>,
    /// The gel's width, height and thickness, mm, as in 30,30,10: enables depth, contact and force from elasticity;
    /// stored
    #[arg(long, value_name = "W,H,T", value_parser = gel)]
    gel_mm: Option<Gel>,
    /// The gel's Young's modulus, MPa, if it is known: force needs it, or a column `force_z_n` in the presses'
    /// depth.csv; stored
    #[arg(long, value_name = "MPA", value_parser = modulus)]
    youngs_modulus_mpa: Option<f64>,
    /// Take the recordings with this camera when you press Enter: camera:ID; without a value the only camera
    ///
    /// A page shows the camera's image; page and terminal show its exposure and focus.
    #[arg(long, value_name = "CAMERA", num_args = 0..=1, default_missing_value = "camera")]
    camera: Option<PathBuf>,
    #[command(flatten)]
    page: PageArgs,
    #[command(flatten)]
    output: OutputArgs,
}

/// Width, height and thickness, mm.
type Gel = [f64; 3];

/// The state of the calibration.
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
    let lines = (is_attended || args.camera.is_some()).then(|| Lines::of(io::stdin()));
    let mut camera = None;
    loop {
        let progress = Progress::new(args, &answers)?;
        args.output.result(out, &progress, &progress.to_string())?;
        let redo = progress.steps.iter().find_map(Step::fault);
        if progress.outcome.is_some() {
            return Ok(());
        }
        let Some(lines) = &lines else { return redo.map_or(Ok(()), Err) };
        let next = progress.steps.iter().find(|step| step.is_open());
        if let (Some(place), Some(step)) = (&args.camera, next.filter(|step| step.folder.is_some())) {
            if !take(step, place, &mut camera, args, lines, out)? {
                return redo.map_or(Ok(()), Err);
            }
            continue;
        }
        let Some(heard) = hear(next.map(|step| step.kind), lines, out)? else { return Ok(()) };
        answers = answers.with(&heard);
    }
}

/// Takes the recording of a step with the camera, which is opened first; false at the end of the input.
fn take(
    step: &Step,
    place: &Path,
    camera: &mut Option<LiveCamera>,
    args: &GuideArgs,
    lines: &Lines,
    out: &mut impl Write,
) -> Result<bool, Failure> {
    let path = args.folder.join(PROFILE);
    let profile = if path.exists() { Profile::load(&path)? } else { Profile::default() };
    let (region, capture) = (profile.image.map(|image| image.region_of_interest), profile.capture.clone());
    // Values that are fitted later must not affect the page.
    let bare = Profile { image: profile.image, capture, flow: profile.flow, ..Profile::default() };
    let camera = match camera {
        Some(camera) => camera,
        None => camera.insert(LiveCamera::open(place, bare, args.page, args.output)?),
    };
    let region = region.map(|[x, y, width, height]| Rect { x, y, width, height });
    let line = args.output.line();
    let taken = Shoot { camera, lines, out, line: line.clone(), region, best_sharpness: 0.0 }.take(step);
    line.finish_and_clear();
    taken
}

/// Waits for a line: an answer to the question, or an empty one. After an invalid answer the question is repeated; none
/// at the end of the input.
fn hear(next: Option<Kind>, lines: &Lines, out: &mut impl Write) -> Result<Option<Given>, Failure> {
    let asked = if next == Some(Kind::Distance) {
        "The distance in mm, as in 25±0.5, then Enter"
    } else {
        "Press Enter to check again"
    };
    loop {
        writeln!(out, "\n{asked}; Ctrl-C ends.")?;
        out.flush()?;
        let Some(line) = lines.next() else { return Ok(None) };
        match (next, line.trim()) {
            (_, "") => return Ok(Some(Given::default())),
            (Some(Kind::Distance), text) => match distance(text) {
                Ok(distance) => return Ok(Some(Given { distance: Some(distance), ..Given::default() })),
                Err(form) => writeln!(out, "{text} is not a distance: {form}")?,
            },
            (_, text) => writeln!(out, "there is no question to which {text} is the answer")?,
        }
    }
}

impl<'a> Progress<'a> {
    /// Checks the folder, creates the folder for the next recording, and calibrates when all are there.
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
        Failure::new(message, "name a writable folder with --folder")
    })
}

/// A measured distance, mm.
fn distance(text: &str) -> Result<Prior, String> {
    let form = |_| "expected the distance and its standard deviation, above 0 mm, as in 25±0.5 or 25+-0.5".to_string();
    Prior::parse(&format!("distance_mm={text}")).map(|(_, prior)| prior).map_err(form)
}

/// A length, mm.
fn length(text: &str) -> Result<f64, String> {
    let length = text.trim().parse().ok().filter(|value| (0.1..=1000.0).contains(value));
    length.ok_or_else(|| "expected a length in mm, 0.1 to 1000".into())
}

/// The gel's width, height and thickness, mm.
fn gel(text: &str) -> Result<Gel, String> {
    let lengths: Result<Vec<f64>, String> = text.split(',').map(length).collect();
    let lengths = lengths.ok().and_then(|lengths| Gel::try_from(lengths).ok());
    lengths.ok_or_else(|| "expected width, height and thickness in mm, as in 30,30,10".into())
}

/// A stiffness, MPa.
fn modulus(text: &str) -> Result<f64, String> {
    let modulus = text.trim().parse().ok().filter(|value: &f64| *value > 0.0 && *value <= 1e4);
    modulus.ok_or_else(|| "expected a stiffness in MPa above 0, as in 0.6 for soft silicone".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heard(next: Kind, typed: &str) -> (Option<Given>, String) {
        let mut said = Vec::new();
        let lines = Lines::of(io::Cursor::new(typed.to_owned()));
        let heard = hear(Some(next), &lines, &mut said).unwrap();
        (heard, String::from_utf8(said).unwrap())
    }

    #[test]
    fn a_distance_that_is_typed_is_taken() {
        let (given, said) = heard(Kind::Distance, "far\n25±0.5\n");
        assert_eq!(given.unwrap().distance, Some(Prior { value: 25.0, deviation: 0.5 }));
        assert!(said.contains("far is not a distance: expected"), "{said}");
    }

    #[test]
    fn an_empty_line_looks_again_and_the_end_of_the_input_ends() {
        assert!(heard(Kind::Board, "\n").0.unwrap().distance.is_none());
        assert!(heard(Kind::Board, "").0.is_none());
        assert!(heard(Kind::Board, "25±0.5\n").1.contains("there is no question to which 25±0.5 is the answer"));
    }

    #[test]
    fn a_gel_is_three_lengths() {
        assert_eq!(gel("30, 30,10"), Ok([30.0, 30.0, 10.0]));
        assert!(gel("30,30").is_err() && gel("30,30,0").is_err() && gel("30,30,10000").is_err());
    }
}

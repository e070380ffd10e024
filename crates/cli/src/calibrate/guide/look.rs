//! What a sensor's folder holds so far, and what that is worth.

use std::fs;
use std::path::{Path, PathBuf};

use fingervision_calibrate::check::{BoardCheck, Check, Fault, PressCheck, RecordingCheck, StillCheck};
use fingervision_calibrate::depth::PressFolder;
use fingervision_source::{Options, SourceError, open};
use fingervision_touch::Profile;
use serde::Serialize;

use crate::failure::Failure;
use crate::output::OutputArgs;

use super::PROFILE;
use super::answers::Answers;

/// Fewer presses do not show whether one law holds all over the image: centre, midway and corner.
const LEAST_PRESSES: usize = 3;

/// A part of the calibration that somebody has to do.
#[derive(Debug, Serialize)]
pub(super) struct Step {
    pub(super) name: String,
    #[serde(skip)]
    pub(super) kind: Kind,
    pub(super) state: State,
    /// Where its recording belongs; absent for a question.
    pub(super) folder: Option<PathBuf>,
    /// What its recording is worth, once there is one.
    pub(super) check: Option<RecordingCheck>,
    /// The answer to a question.
    pub(super) answer: Option<String>,
}

/// What is to be done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Still,
    Board,
    Distance,
    Press,
}

/// How far a step is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum State {
    Done,
    Redo,
    Next,
    Later,
}

impl Step {
    /// What is wrong with its recording, as an error.
    pub(super) fn fault(&self) -> Option<Failure> {
        let fault = self.check.as_ref()?.faults.first()?;
        Some(Failure::new(format!("{}: {fault}", self.name), &fault.remedy))
    }

    fn question(kind: Kind, name: &str, answer: Option<String>) -> Self {
        let state = if answer.is_some() { State::Done } else { State::Later };
        Self { name: name.into(), kind, state, folder: None, check: None, answer }
    }

    fn recording(kind: Kind, folder: PathBuf, check: Option<RecordingCheck>) -> Self {
        let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let state = match &check {
            Some(check) if check.is_sound() => State::Done,
            Some(_) => State::Redo,
            None => State::Later,
        };
        Self { name, kind, state, folder: Some(folder), check, answer: None }
    }
}

/// Every step in its order. The first that is missing is next, unless one before it must be done again.
pub(super) fn look(folder: &Path, answers: &Answers, output: OutputArgs) -> Result<Vec<Step>, Failure> {
    let path = folder.join(PROFILE);
    let mut profile = if path.exists() { Profile::load(&path)? } else { Profile::default() };
    let still = Step::recording(Kind::Still, folder.join("still"), still(&folder.join("still"), &profile, output));
    if let Some(noise) = noise_to_set(&still, &profile) {
        profile.flow.noise_levels = noise;
    }
    let board = board(&folder.join("board"), &profile, answers, output);
    let distance = answers.distance().map(|prior| format!("{} ± {} mm", prior.value, prior.deviation));
    let mut steps = vec![
        still,
        Step::recording(Kind::Board, folder.join("board"), board),
        Step::question(Kind::Distance, "distance", distance),
    ];
    for folder in press_folders(folder) {
        let check = press(&folder, &profile, output);
        steps.push(Step::recording(Kind::Press, folder, check));
    }
    if let Some(step) =
        steps.iter_mut().find(|step| step.state != State::Done).filter(|step| step.state == State::Later)
    {
        step.state = State::Next;
    }
    Ok(steps)
}

/// The camera's noise, grey levels, where a sound recording shows that the profile's is off by a quarter or more. Half a
/// level is what rounding and a lossless file leave at least.
pub(super) fn noise_to_set(still: &Step, profile: &Profile) -> Option<f32> {
    let check = still.check.as_ref().filter(|check| check.is_sound())?;
    let noise = check.noise_levels?.max(0.5);
    let ratio = noise / f64::from(profile.flow.noise_levels);
    (!(0.8..=1.25).contains(&ratio)).then_some(((100.0 * noise).round() / 100.0) as f32)
}

fn still(folder: &Path, profile: &Profile, output: OutputArgs) -> Option<RecordingCheck> {
    judge(folder, output, |size, is_colour| {
        let region = profile.region(size).map_err(|error| Fault::unreadable(&error, error.hint()))?;
        let check = StillCheck::new(region, is_colour, &profile.flow);
        Ok(Box::new(check.map_err(|error| Fault::unreadable(&error, None))?))
    })
}

fn board(folder: &Path, profile: &Profile, answers: &Answers, output: OutputArgs) -> Option<RecordingCheck> {
    judge(folder, output, |size, is_colour| {
        let region = profile.region(size).map_err(|error| Fault::unreadable(&error, error.hint()))?;
        let check = BoardCheck::new(region, is_colour, &profile.flow, answers.slide());
        Ok(Box::new(check.map_err(|error| Fault::from(&error))?))
    })
}

fn press(folder: &Path, profile: &Profile, output: OutputArgs) -> Option<RecordingCheck> {
    if is_empty(folder) {
        return None;
    }
    match PressFolder::open(folder) {
        Ok(press) => judge(&press.images, output, |size, is_colour| {
            Ok(Box::new(PressCheck::new(&press, profile, size, is_colour)?))
        }),
        Err(error) => Some(RecordingCheck::refused(Fault::from(&error))),
    }
}

/// Checks the recording of a folder; none where there is nothing in it.
fn judge(
    folder: &Path,
    output: OutputArgs,
    make: impl FnOnce((usize, usize), bool) -> Result<Box<dyn Check>, Fault>,
) -> Option<RecordingCheck> {
    if is_empty(folder) {
        return None;
    }
    let folder = images_of(folder);
    let unreadable = |error: SourceError| Fault::unreadable(&error, error.hint());
    let read = || {
        let mut source = open(&folder, &Options::default()).map_err(unreadable)?;
        let size = source.size();
        let bar = output.progress("checking", source.frame_count());
        let Some(first) = source.next_frame().map_err(unreadable)? else { return Ok(RecordingCheck::default()) };
        let mut check = make(size, first.pixels.is_colour())?;
        let mut next = Some(first);
        while let Some(frame) = next {
            check.push(&frame);
            bar.inc(1);
            next = source.next_frame().map_err(unreadable)?;
        }
        bar.finish_and_clear();
        Ok(check.finish())
    };
    Some(read().unwrap_or_else(RecordingCheck::refused))
}

/// Where a recording's images are: in its subfolder frames, as a simulation writes it, or in itself.
pub(super) fn images_of(folder: &Path) -> PathBuf {
    let frames = folder.join("frames");
    if frames.is_dir() { frames } else { folder.into() }
}

fn is_empty(folder: &Path) -> bool {
    fs::read_dir(folder).map_or(true, |mut entries| entries.next().is_none())
}

/// The folders named press and something, by number, then those that are still missing.
fn press_folders(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let is_press = |path: &PathBuf| path.is_dir() && name(path).starts_with("press") && !is_empty(path);
    let mut presses: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(is_press).collect();
    let missing = (1..).map(|number| folder.join(format!("press-{number}")));
    let missing = missing.filter(|path| !presses.contains(path)).take(LEAST_PRESSES.saturating_sub(presses.len()));
    let missing: Vec<PathBuf> = missing.collect();
    presses.extend(missing);
    let number =
        |path: &PathBuf| name(path).trim_start_matches("press").trim_start_matches('-').parse().unwrap_or(u64::MAX);
    presses.sort_by_key(|path| (number(path), name(path)));
    presses
}

//! The recordings and answers in a sensor's folder, and the results of their checks.

use std::fs;
use std::path::{Path, PathBuf};

use fingervision_calibrate::check::{BoardCheck, Check, Fault, PressCheck, RecordingCheck, StillCheck, What};
use fingervision_calibrate::depth::PressFolder;
use fingervision_image::Frame;
use fingervision_simulation::open;
use fingervision_source::{Options, SourceError, images_of};
use fingervision_touch::Profile;
use serde::Serialize;

use crate::calibrate::repeated::repeated_fault;
use crate::failure::Failure;
use crate::output::OutputArgs;

use super::PROFILE;
use super::answers::Answers;
use super::checks::{Checks, Key};

/// Least number of presses: at the centre, midway and near a corner, to show whether one law fits everywhere in the
/// image.
const LEAST_PRESSES: usize = 3;

/// A step of the calibration for the user.
#[derive(Debug, Serialize)]
pub(super) struct Step {
    pub(super) name: String,
    #[serde(skip)]
    pub(super) kind: Kind,
    pub(super) state: State,
    /// The folder of its recording; absent for a question.
    pub(super) folder: Option<PathBuf>,
    /// The result for its recording, if there is one.
    pub(super) check: Option<RecordingCheck>,
    /// The answer to a question.
    pub(super) answer: Option<String>,
}

/// The kinds of steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Still,
    Board,
    Distance,
    View,
    Gel,
    Press,
}

/// The state of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum State {
    Done,
    Redo,
    Next,
    Later,
    /// An optional question.
    Optional,
}

impl Step {
    /// The fault of its recording, as an error.
    pub(super) fn fault(&self) -> Option<Failure> {
        let fault = self.check.as_ref()?.faults.first()?;
        Some(Failure::new(format!("{}: {fault}", self.name), &fault.remedy))
    }

    /// Whether the calibration waits for it.
    pub(super) fn is_open(&self) -> bool {
        !matches!(self.state, State::Done | State::Optional)
    }

    fn question(kind: Kind, name: &str, answer: Option<String>) -> Self {
        let state = match kind {
            _ if answer.is_some() => State::Done,
            Kind::View | Kind::Gel => State::Optional,
            _ => State::Later,
        };
        Self { name: name.into(), kind, state, folder: None, check: None, answer }
    }

    pub(super) fn recording(kind: Kind, folder: PathBuf, check: Option<RecordingCheck>) -> Self {
        let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let state = match &check {
            Some(check) if check.is_sound() => State::Done,
            Some(_) => State::Redo,
            None => State::Later,
        };
        Self { name, kind, state, folder: Some(folder), check, answer: None }
    }
}

/// Every step in order. The first that is missing is next, unless an earlier one must be repeated. Recordings that have
/// not changed are not checked again.
pub(super) fn look(folder: &Path, answers: &Answers, output: OutputArgs) -> Result<Vec<Step>, Failure> {
    let path = folder.join(PROFILE);
    let profile = if path.exists() { Profile::load(&path)? } else { Profile::default() };
    // Values that are fitted later must not affect the check of a recording.
    let (image, flow, references) = (profile.image, profile.flow, profile.references);
    let mut bare = Profile { image, flow, references, ..Profile::default() };
    let mut looker = Looker { checks: Checks::load(folder), output };
    let place = folder.join("still");
    // Neither must the noise that is being measured.
    bare.flow.noise_levels = Profile::default().flow.noise_levels;
    let still = Step::recording(Kind::Still, place.clone(), looker.still(&place, &bare));
    bare.flow.noise_levels = noise_to_set(&still).unwrap_or(profile.flow.noise_levels);
    let rest = still.check.as_ref().filter(|check| check.is_sound()).map(|_| place.as_path());
    let place = folder.join("board");
    let board = looker.board(&place, &bare, answers, rest);
    let distance = answers.distance().map(|prior| format!("{} ± {} mm", prior.value, prior.deviation));
    let view = answers.view_mm().map(|view| format!("{view} mm"));
    let gel = answers.gel().map(|gel| {
        let modulus = gel.youngs_modulus_mpa.map(|modulus| format!(", {modulus} MPa")).unwrap_or_default();
        format!("{} × {} × {} mm{modulus}", gel.size_mm[0], gel.size_mm[1], gel.thickness_mm)
    });
    let mut steps = vec![
        still,
        Step::recording(Kind::Board, place, board),
        Step::question(Kind::Distance, "distance", distance),
        Step::question(Kind::View, "view", view),
        Step::question(Kind::Gel, "gel", gel),
    ];
    let mut places: Vec<PathBuf> = Vec::new();
    for place in press_folders(folder) {
        let check = match repeated_fault(&place, places.iter().map(PathBuf::as_path)) {
            Some(fault) => Some(RecordingCheck::refused(fault)),
            None => looker.press(&place, &bare, rest),
        };
        places.push(place.clone());
        steps.push(Step::recording(Kind::Press, place, check));
    }
    looker.checks.save();
    if let Some(step) = steps.iter_mut().find(|step| step.is_open()).filter(|step| step.state == State::Later) {
        step.state = State::Next;
    }
    Ok(steps)
}

/// The camera's noise by a valid recording of the untouched gel, grey levels. Rounding and a lossless file cause at
/// least half a level.
pub(super) fn noise_to_set(still: &Step) -> Option<f32> {
    let check = still.check.as_ref().filter(|check| check.is_sound())?;
    let noise = check.noise_levels?.max(0.5);
    Some(((100.0 * noise).round() / 100.0) as f32)
}

/// Checks recordings, each once.
struct Looker {
    checks: Checks,
    output: OutputArgs,
}

impl Looker {
    fn still(&mut self, folder: &Path, profile: &Profile) -> Option<RecordingCheck> {
        self.judge(folder, &profile.to_toml(), None, |size, is_colour, _| {
            let region = profile.region(size).map_err(|error| Fault::unreadable(&error, error.hint()))?;
            let check = StillCheck::new(region, is_colour, &profile.flow);
            Ok(Box::new(check.map_err(|error| Fault::unreadable(&error, None))?))
        })
    }

    fn board(
        &mut self,
        folder: &Path,
        profile: &Profile,
        answers: &Answers,
        rest: Option<&Path>,
    ) -> Option<RecordingCheck> {
        let slide = answers.slide();
        let settings = format!("{}{slide:?}", profile.to_toml());
        self.judge(folder, &settings, rest, |size, is_colour, rest| {
            of_one_size(size, rest)?;
            let region = profile.region(size).map_err(|error| Fault::unreadable(&error, error.hint()))?;
            let check = BoardCheck::new(region, is_colour, &profile.flow, slide);
            Ok(Box::new(check.map_err(|error| Fault::from(&error))?))
        })
    }

    fn press(&mut self, folder: &Path, profile: &Profile, rest: Option<&Path>) -> Option<RecordingCheck> {
        if is_empty(folder) {
            return None;
        }
        let press = match PressFolder::open(folder) {
            Ok(press) => press,
            Err(error) => return Some(RecordingCheck::refused(Fault::from(&error))),
        };
        self.judge(folder, &profile.to_toml(), rest, |size, is_colour, rest| {
            of_one_size(size, rest)?;
            let check = PressCheck::new(&press, profile, size, is_colour)?;
            Ok(Box::new(match rest {
                Some(rest) => check.with_rest(rest)?,
                None => check,
            }))
        })
    }

    /// Checks the recording of a folder, compared with the untouched gel if that is known; none if the folder is empty.
    fn judge(
        &mut self,
        folder: &Path,
        settings: &str,
        rest: Option<&Path>,
        make: impl FnOnce((usize, usize), bool, Option<&Frame>) -> Result<Box<dyn Check>, Fault>,
    ) -> Option<RecordingCheck> {
        if is_empty(folder) {
            return None;
        }
        let key = Key::of(settings, [Some(folder), rest].into_iter().flatten());
        if let Some(check) = self.checks.of(folder, key) {
            return Some(check);
        }
        let check = self.read(folder, rest, make).unwrap_or_else(RecordingCheck::refused);
        self.checks.keep(folder, key, &check);
        Some(check)
    }

    fn read(
        &self,
        folder: &Path,
        rest: Option<&Path>,
        make: impl FnOnce((usize, usize), bool, Option<&Frame>) -> Result<Box<dyn Check>, Fault>,
    ) -> Result<RecordingCheck, Fault> {
        let unreadable = |error: SourceError| Fault::unreadable(&error, error.hint());
        let rest = rest.map(|rest| open(images_of(rest), &Options::default())?.next_frame()).transpose();
        let rest = rest.map_err(unreadable)?.flatten();
        let mut source = open(images_of(folder), &Options::default()).map_err(unreadable)?;
        let size = source.size();
        let bar = self.output.progress("checking", source.frame_count());
        let Some(first) = source.next_frame().map_err(unreadable)? else { return Ok(RecordingCheck::default()) };
        let mut check = make(size, source.tracks_in_colour(&first.pixels), rest.as_ref())?;
        let mut next = Some(first);
        while let Some(frame) = next {
            check.push(&frame);
            bar.inc(1);
            next = source.next_frame().map_err(unreadable)?;
        }
        bar.finish_and_clear();
        Ok(check.finish())
    }
}

/// Refuses images of another size than those of the untouched gel.
fn of_one_size((width, height): (usize, usize), rest: Option<&Frame>) -> Result<(), Fault> {
    let Some((columns, rows)) = rest.map(|rest| rest.pixels.size()).filter(|&size| size != (width, height)) else {
        return Ok(());
    };
    let (measured, allowed) = (format!("images of {width}x{height} px"), format!("{columns}x{rows} px, as in still"));
    let remedy = "take all recordings with this sensor's camera, at one size";
    Err(Fault::new(What::OtherSensor, measured, allowed, remedy))
}

fn is_empty(folder: &Path) -> bool {
    fs::read_dir(folder).map_or(true, |mut entries| entries.next().is_none())
}

/// The folders whose names begin with press, by number, then those that are still missing.
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

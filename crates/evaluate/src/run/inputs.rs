//! Opens a run and its truth, and checks that they belong together.

use std::path::{Path, PathBuf};

use fingervision_image::Rect;
use fingervision_optics::{Camera, CameraParams};
use fingervision_settings::Document;
use fingervision_touch::ImageSection;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::border::BorderBand;
use super::fields::Fields;
use super::grid::{self, Grid};
use super::origin::{Source, expect_same_scene};
use super::table_file::{Forces, read_forces};
use super::{BORDER_MM, Options, RunError, numbers};

/// A run and its truth, ready to be read frame by frame.
#[derive(Debug)]
pub(super) struct Inputs {
    pub(super) run_folder: PathBuf,
    pub(super) truth_folder: PathBuf,
    pub(super) run: Fields,
    pub(super) truth: Fields,
    /// The part of the truth's grid that the run covers.
    pub(super) place: Rect,
    /// Absent if there is no contact or no camera.
    pub(super) band: Option<BorderBand>,
    /// Estimated and true; absent unless both are known.
    pub(super) forces: Option<[Forces; 2]>,
    pub(super) frames: u64,
    /// The numbers of the run's frames in the truth, unless it begins with frame 0 and has no gap.
    numbers: Option<Vec<u64>>,
    /// Number of truth frames to advance for each frame of the run; 1 beyond its end.
    truth_steps: std::vec::IntoIter<u64>,
    pub(super) notes: Vec<String>,
}

/// The parts of a run's `run.toml` that are read; other keys are ignored.
#[derive(Debug, Default, Deserialize)]
struct RunRecord {
    #[serde(default)]
    profile: Sensor,
    source: Option<Source>,
    part: Option<Part>,
}

/// The parts of the record of a tracked part that are read.
#[derive(Debug, Deserialize)]
struct Part {
    /// The frame that displacement is relative to, if it is not the first one.
    reference: Option<u64>,
}

/// The parts of a profile that are read.
#[derive(Debug, Default, Deserialize)]
struct Sensor {
    image: Option<ImageSection>,
    camera: Option<CameraParams>,
}

impl Sensor {
    fn region(&self) -> Option<[usize; 4]> {
        self.image.map(|image| image.region_of_interest)
    }
}

impl Inputs {
    pub(super) fn open(run_path: &Path, truth_path: &Path, options: Options) -> Result<Self, RunError> {
        let run = open_run(run_path)?;
        let (truth_folder, truth) = open_truth(truth_path)?;
        let mut notes = Vec::new();
        let (run_file, truth_file) = (run_path.join("run.toml"), profile_beside(truth_path, &truth_folder));
        let record: RunRecord = read_toml("run record", &run_file)?.unwrap_or_else(|| {
            notes.push("run.toml is absent: the run is assumed to cover the whole grid of the truth".into());
            RunRecord::default()
        });
        notes.extend(record.part.as_ref().and_then(|part| part.reference).and_then(reference_note));
        expect_same_scene(run_path, record.source.as_ref(), [truth_path, &truth_folder])?;
        let sensor: Sensor = read_toml("profile", &truth_file)?.unwrap_or_default();
        let run_grid = Grid { size: run.size(), region: record.profile.region(), file: &run_file };
        let truth_grid = Grid { size: truth.size(), region: sensor.region(), file: &truth_file };
        let place = grid::place(run_grid, truth_grid)?;

        let (run, truth) = in_common((run_path, run), (truth_path, truth), &mut notes)?;
        let band = band(&truth, sensor.camera.as_ref(), &truth_file, &mut notes)?;
        let mut forces = forces(run_path, &truth_folder, &mut notes)?;
        let mut counts = run.frame_counts();
        let mut truth_counts = truth.frame_counts();
        let held = truth_counts.iter().map(|file| file.1).min().unwrap_or_default();
        let part = numbers::part(&run_path.join("readings.csv"), held)?;
        if let Some(part) = &part {
            notes.push(part_note(part));
            for file in &mut truth_counts {
                file.1 = part.len() as u64;
            }
            forces = forces.and_then(|[estimated, truth]| Some([estimated, rows(&truth, part)?]));
        }
        counts.extend(truth_counts);
        if let Some([estimated, truth]) = &forces {
            counts.push((run_path.join("readings.csv"), estimated.len() as u64));
            counts.push((truth_folder.join("force.csv"), truth.len() as u64));
        }
        let frames = frame_count(&counts, options, &mut notes)?;
        let run_folder = run_path.to_owned();
        let truth_steps = numbers::steps(part.as_deref().unwrap_or_default()).into_iter();
        let numbers = part;
        Ok(Self { run_folder, truth_folder, run, truth, place, band, forces, frames, numbers, truth_steps, notes })
    }

    /// The number of the frame in this row of the run's arrays.
    pub(super) fn number(&self, row: usize) -> u64 {
        self.numbers.as_ref().map_or(row as u64, |numbers| numbers[row])
    }

    /// Reads the next frame of all arrays.
    pub(super) fn advance(&mut self) -> Result<(), RunError> {
        self.run.advance()?;
        let steps = self.truth_steps.next().unwrap_or(1);
        (0..steps).try_for_each(|_| self.truth.advance())
    }
}

/// A truth is always relative to the first frame.
fn reference_note(reference: u64) -> Option<String> {
    (reference > 0).then(|| {
        format!(
            "the run is relative to frame {reference}, the truth to frame 0: the errors are only valid if the gel is untouched in \
             both"
        )
    })
}

fn part_note(numbers: &[u64]) -> String {
    let (first, last) = (numbers.first().copied().unwrap_or(0), numbers.last().copied().unwrap_or(0));
    format!(
        "the run contains {} frames, numbers {first} to {last} of the recording: each is compared with the truth's frame of the same \
         number",
        numbers.len()
    )
}

/// The forces of these frames; none if some are missing.
fn rows(forces: &Forces, numbers: &[u64]) -> Option<Forces> {
    numbers.iter().map(|&number| forces.get(usize::try_from(number).ok()?).copied()).collect()
}

fn open_run(folder: &Path) -> Result<Fields, RunError> {
    let run = Fields::open(folder, "valid.npy")?;
    if run.flow.is_some() || run.depth.is_some() {
        return Ok(run);
    }
    let hint = if folder.join("truth").is_dir() {
        "this is a simulation: give the run first, then the simulation as its truth"
    } else {
        "a run is a folder that `fingervision track --out` wrote, or any with such a flow.npy or depth.npy"
    };
    Err(RunError::NoFields { folder: folder.to_owned(), hint: hint.into() })
}

/// The folder with the true arrays: the given one, or its subfolder `truth`.
fn open_truth(path: &Path) -> Result<(PathBuf, Fields), RunError> {
    let below = path.join("truth");
    let folder = if below.is_dir() { below } else { path.to_owned() };
    let truth = Fields::open(&folder, "visible.npy")?;
    if truth.flow.is_some() || truth.depth.is_some() {
        return Ok((folder, truth));
    }
    let hint = "a truth is a folder that `fingervision simulate --out` wrote, or its subfolder truth".into();
    Err(RunError::NoFields { folder, hint })
}

/// The `profile.toml` of a truth: beside the arrays, or beside the folder `truth` that contains them.
fn profile_beside(path: &Path, folder: &Path) -> PathBuf {
    let beside = path.join("profile.toml");
    let is_named_truth = || folder.canonicalize().is_ok_and(|folder| folder.ends_with("truth"));
    if !beside.exists() && is_named_truth() { folder.join("../profile.toml") } else { beside }
}

fn read_toml<T: DeserializeOwned>(noun: &'static str, path: &Path) -> Result<Option<T>, RunError> {
    let document = Document::new(noun);
    match document.read(path) {
        Err(error) if error.is_not_found() => Ok(None),
        text => Ok(Some(document.parse(&text?).map_err(|error| error.in_file(path))?)),
    }
}

/// Drops fields that only one side contains, except those that show where the truth is visible and touched.
fn in_common(
    (run_path, mut run): (&Path, Fields),
    (truth_path, mut truth): (&Path, Fields),
    notes: &mut Vec<String>,
) -> Result<(Fields, Fields), RunError> {
    let (run_holds, truth_holds) = (run.names(), truth.names());
    let is_missing = |name, is_in_run, is_in_truth, notes: &mut Vec<String>| {
        if is_in_run != is_in_truth {
            let here = if is_in_run { "run" } else { "truth" };
            notes.push(format!("{name}.npy is only in the {here}: it is not compared"));
        }
        !(is_in_run && is_in_truth)
    };
    if is_missing("flow", run.flow.is_some(), truth.flow.is_some(), notes) {
        run.flow = None;
    }
    if is_missing("depth", run.depth.is_some(), truth.depth.is_some(), notes) {
        run.depth = None;
    }
    let is_asked = run.displacement.is_some();
    if !is_asked || is_missing("displacement", is_asked, truth.displacement.is_some(), notes) {
        (run.displacement, truth.displacement) = (None, None);
    }
    if truth.contact.is_none() {
        run.contact = None;
        notes.push("the truth has no contact.npy: errors are not separated by region".into());
    }
    if run.mask.is_none() {
        notes.push("valid.npy is absent: every finite pixel of the run counts as valid".into());
    }
    if truth.mask.is_none() {
        notes.push("visible.npy is absent: every finite pixel of the truth counts as visible".into());
    }
    if run.flow.is_some() || run.depth.is_some() {
        return Ok((run, truth));
    }
    let (run, truth) = (run_path.to_owned(), truth_path.to_owned());
    Err(RunError::NothingInCommon { run, run_holds, truth, truth_holds })
}

fn band(
    truth: &Fields,
    camera: Option<&CameraParams>,
    file: &Path,
    notes: &mut Vec<String>,
) -> Result<Option<BorderBand>, RunError> {
    match camera {
        _ if truth.contact.is_none() => Ok(None),
        Some(params) => {
            let no_camera = |error| RunError::Camera { file: file.to_owned(), error };
            let camera = Camera::new(params).map_err(no_camera)?;
            Ok(Some(BorderBand::new(&camera, truth.size(), BORDER_MM)))
        }
        None => {
            let what = format!("within {BORDER_MM} mm of the contact's border and outside");
            notes.push(format!("the truth has no profile.toml with a camera: errors {what} are not known"));
            Ok(None)
        }
    }
}

/// Estimated and true forces, if any are in both tables.
fn forces(run: &Path, truth: &Path, notes: &mut Vec<String>) -> Result<Option<[Forces; 2]>, RunError> {
    let holds_any = |forces: &Forces| forces.iter().flatten().any(Option::is_some);
    let Some(true_forces) = read_forces(&truth.join("force.csv"))?.filter(holds_any) else {
        notes.push("the truth has no force.csv: forces are not compared".into());
        return Ok(None);
    };
    let readings = read_forces(&run.join("readings.csv"))?;
    let estimated = readings.filter(holds_any);
    if estimated.is_none() {
        notes.push("the run has no force in a readings.csv: forces are not compared".into());
    }
    Ok(estimated.map(|estimated| [estimated, true_forces]))
}

/// The number of frames that all files contain.
fn frame_count(counts: &[(PathBuf, u64)], options: Options, notes: &mut Vec<String>) -> Result<u64, RunError> {
    let by_count = |file: &&(PathBuf, u64)| file.1;
    let (Some(least), Some(most)) = (counts.iter().min_by_key(by_count), counts.iter().rev().max_by_key(by_count))
    else {
        return Ok(0);
    };
    if least.1 == most.1 {
        return Ok(least.1);
    }
    if !options.common_frames || least.1 == 0 {
        return Err(RunError::FrameCounts { first: least.clone(), second: most.clone() });
    }
    let (file, frames) = least;
    notes.push(format!("{} contains {frames} of {} frames: only these are compared", file.display(), most.1));
    Ok(*frames)
}

//! Refuses a recording that is given twice. It would count twice and, as a recording that is left out to test a fit, make
//! the fit look better than it is.

use std::path::Path;

use fingervision_calibrate::check::{Fault, What};
use fingervision_gel::Scene;
use fingervision_simulation::SimulatedLocation;
use fingervision_source::{Repetition, images_of, repetition};

use super::press::scene_location;
use crate::failure::Failure;

/// Refuses recordings, folders or scenes, of which two are the same; `noun` is the name of one, as in press.
pub(super) fn refuse_repeated<P: AsRef<Path>>(noun: &str, recordings: &[P]) -> Result<(), Failure> {
    for (number, later) in recordings.iter().map(AsRef::as_ref).enumerate() {
        for earlier in recordings[..number].iter().map(AsRef::as_ref) {
            let Some(same) = same(earlier, later) else { continue };
            let message = if earlier.as_os_str() == later.as_os_str() {
                format!("{} is given twice", later.display())
            } else {
                format!("{} is {same} {}", later.display(), earlier.display())
            };
            return Err(Failure::new(
                message,
                format!("give every {noun} once: the same images do not improve the fit"),
            ));
        }
    }
    Ok(())
}

/// The fault of a press that is the same as one of the earlier presses.
pub(super) fn repeated_fault<'a>(press: &Path, mut earlier: impl Iterator<Item = &'a Path>) -> Option<Fault> {
    let (other, same) = earlier.find_map(|other| Some((other, same(other, press)?)))?;
    let measured = format!("it is {same} {}", other.file_name().unwrap_or_default().display());
    let remedy = "record another press, or remove this folder if there are enough presses";
    Some(Fault::new(What::Copies, measured, "another press", remedy))
}

/// How the later of two recordings is the same as the earlier, if it is.
fn same(earlier: &Path, later: &Path) -> Option<&'static str> {
    match (scene(earlier), scene(later)) {
        (Some(a), Some(b)) => (a == b).then_some("the same scene as"),
        (None, None) => repetition(&images_of(earlier), &images_of(later)).map(|repetition| match repetition {
            Repetition::SamePlace => "the same recording as",
            Repetition::Copy => "a copy of",
        }),
        _ => None,
    }
}

/// The scene of a simulated recording.
fn scene(recording: &Path) -> Option<Scene> {
    let location = scene_location(recording.to_str().filter(|_| !recording.is_dir())?)?;
    SimulatedLocation::of(Path::new(&location)).ok()??.scene().ok()
}

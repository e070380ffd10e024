//! The fingerprint of a sensor's pattern: taken from a recording, written to its profile.

use std::path::Path;

use fingervision_calibrate::depth::PressFolder;
use fingervision_calibrate::{load_to_update, update_profile};
use fingervision_image::{Frame, Image, grey_into};
use fingervision_simulation::open;
use fingervision_source::Options;
use fingervision_touch::{Fingerprint, PatternSection, Profile};

use crate::failure::Failure;

/// The grey levels of the region of interest.
pub(crate) fn grey(frame: &Frame, profile: &Profile) -> Result<Image<f32>, Failure> {
    let region = profile.region(frame.pixels.size())?;
    let mut grey = Image::filled(region.width, region.height, 0.0);
    grey_into(&frame.pixels, region, &mut grey)
        .map_err(|error| Failure::new(error.to_string(), "check image.region_of_interest of the profile"))?;
    Ok(grey)
}

/// Writes a fingerprint to a profile's file.
pub(crate) fn write(profile: &Path, fingerprint: Fingerprint) -> Result<(), Failure> {
    let section = PatternSection { fingerprint: Some(fingerprint) };
    Ok(update_profile(profile, "pattern", &section)?)
}

/// Writes the fingerprint of the first press that was recorded, not simulated; nothing if there is none. The first image
/// of a press shows the gel untouched.
pub(crate) fn write_of_presses(presses: &[String], profile: &Path) -> Result<(), Failure> {
    let Some(frame) = first_image(presses)? else { return Ok(()) };
    let grey = grey(&frame, &load_to_update(profile)?)?;
    Fingerprint::of(&grey).map_or(Ok(()), |fingerprint| write(profile, fingerprint))
}

/// The first image of the first press that was recorded; none if all are simulated.
fn first_image(presses: &[String]) -> Result<Option<Frame>, Failure> {
    let Some(press) = presses.iter().map(Path::new).find(|press| press.is_dir()) else { return Ok(None) };
    let images = PressFolder::open(press)?.images;
    Ok(open(&images, &Options::default())?.next_frame()?)
}

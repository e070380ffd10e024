//! The values that a sensor can have.

use fingervision_elastic::{BlockError, GelBlock};
use fingervision_optics::{CameraError, CameraParams};

use crate::{DepthLaw, PerspectiveGain};

use super::{CaptureSection, ImageSection, Profile, ProfileError};

/// Possible distances from a lens to a gel, mm: a value outside is assumed to be in another unit.
const DISTANCES_MM: [f64; 2] = [1.0, 2000.0];
/// Possible sides of a gel, mm.
const SIZES_MM: [f64; 2] = [1.0, 2000.0];
/// Possible thicknesses of a gel, mm.
const THICKNESSES_MM: [f64; 2] = [0.1, 1000.0];

pub(super) fn validate(profile: &Profile) -> Result<(), ProfileError> {
    profile.capture.as_ref().map_or(Ok(()), CaptureSection::validate)?;
    profile.image.as_ref().map_or(Ok(()), validate_image)?;
    profile.camera.as_ref().map_or(Ok(()), validate_camera)?;
    profile.gel.as_ref().map_or(Ok(()), validate_gel)?;
    profile.depth.density.map_or(Ok(()), |law| validate_law(law, profile.camera.is_some()))?;
    profile.flow.validate()?;
    profile.references.validate()?;
    Ok(profile.density.validate()?)
}

fn validate_image(image: &ImageSection) -> Result<(), ProfileError> {
    let region = image.region_of_interest;
    if region[2] > 0 && region[3] > 0 {
        return Ok(());
    }
    let allowed = "[x, y, width, height] with a width and a height above 0 px";
    Err(ProfileError::impossible("image.region_of_interest", format!("{region:?}"), allowed))
}

fn validate_camera(camera: &CameraParams) -> Result<(), ProfileError> {
    camera.validate().map_err(impossible_camera)?;
    let distance_mm = camera.translation_mm[2];
    if (DISTANCES_MM[0]..=DISTANCES_MM[1]).contains(&distance_mm) {
        return Ok(());
    }
    let allowed = "three lengths, of which the last, the distance to the gel, is 1 to 2000 mm";
    Err(ProfileError::impossible("camera.translation_mm", format!("{:?}", camera.translation_mm), allowed))
}

/// An impossible camera in a profile.
pub(super) fn impossible_camera(error: CameraError) -> ProfileError {
    ProfileError::impossible(format!("camera.{}", error.key), error.value, error.allowed)
}

fn validate_law(law: DepthLaw, has_camera: bool) -> Result<(), ProfileError> {
    law.validate()?;
    match law {
        DepthLaw::Perspective(PerspectiveGain { gain }) if !has_camera => {
            let allowed = "used with a [camera] table in the profile, whose perspective it scales; without one use slope_mm and intercept_mm";
            Err(ProfileError::impossible("depth.density.gain", gain.to_string(), allowed))
        }
        _ => Ok(()),
    }
}

fn validate_gel(gel: &GelBlock) -> Result<(), ProfileError> {
    // A size in another unit first: compared with it, the thickness would seem to be wrong.
    let (size, thickness) = (gel.size_mm, gel.thickness_mm);
    let lengths = [
        ("size_mm", &size[..], format!("{size:?}"), SIZES_MM),
        ("thickness_mm", &[thickness], format!("{thickness:?}"), THICKNESSES_MM),
    ];
    for (key, lengths, value, [least, most]) in lengths {
        if lengths.iter().any(|length| *length > 0.0 && !(least..=most).contains(length)) {
            return Err(ProfileError::impossible(format!("gel.{key}"), value, format!("{least} to {most} mm")));
        }
    }
    gel.validate().map_err(|BlockError { key, value, allowed }| {
        ProfileError::impossible(format!("gel.{key}"), format!("{value:?}"), allowed)
    })
}

//! Which values a sensor can have.

use fingervision_elastic::{BlockError, GelBlock};
use fingervision_optics::{CameraError, CameraParams};

use crate::{DepthLaw, PerspectiveGain};

use super::{ImageSection, Profile, ProfileError};

pub(super) fn validate(profile: &Profile) -> Result<(), ProfileError> {
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
    camera.validate().map_err(impossible_camera)
}

/// A camera that cannot be, in a profile.
pub(super) fn impossible_camera(error: CameraError) -> ProfileError {
    ProfileError::impossible(format!("camera.{}", error.key), error.value, error.allowed)
}

fn validate_law(law: DepthLaw, has_camera: bool) -> Result<(), ProfileError> {
    law.validate()?;
    match law {
        DepthLaw::Perspective(PerspectiveGain { gain }) if !has_camera => {
            let allowed =
                "a profile with a [camera] table, whose perspective it scales, or slope_mm and intercept_mm instead";
            Err(ProfileError::impossible("depth.density.gain", gain.to_string(), allowed))
        }
        _ => Ok(()),
    }
}

fn validate_gel(gel: &GelBlock) -> Result<(), ProfileError> {
    gel.validate().map_err(|BlockError { key, value, allowed }| {
        ProfileError::impossible(format!("gel.{key}"), format!("{value:?}"), allowed)
    })
}

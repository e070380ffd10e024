//! Which values a sensor can have.

use fingervision_elastic::{BlockError, GelBlock};
use fingervision_optics::{CameraError, CameraParams};

use super::{ImageSection, Profile, ProfileError};

pub(super) fn validate(profile: &Profile) -> Result<(), ProfileError> {
    profile.image.as_ref().map_or(Ok(()), validate_image)?;
    profile.camera.as_ref().map_or(Ok(()), validate_camera)?;
    profile.gel.as_ref().map_or(Ok(()), validate_gel)?;
    if let Some(line) = profile.depth.density {
        line.validate()?;
    }
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
    let in_table =
        |error: CameraError| ProfileError::impossible(format!("camera.{}", error.key), error.value, error.allowed);
    camera.validate().map_err(in_table)
}

fn validate_gel(gel: &GelBlock) -> Result<(), ProfileError> {
    gel.validate().map_err(|BlockError { key, value, allowed }| {
        ProfileError::impossible(format!("gel.{key}"), format!("{value:?}"), allowed)
    })
}

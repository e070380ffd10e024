//! Which values a sensor can have.

use std::fmt::Debug;

use fingervision_settings::SettingsError;

use super::{CameraSection, GelSection, ImageSection, Profile, ProfileError};

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
    let holds = region[2] > 0 && region[3] > 0;
    check(holds, "image.region_of_interest", region, "[x, y, width, height] with a width and a height above 0 px")
}

fn validate_camera(camera: &CameraSection) -> Result<(), ProfileError> {
    let focal = camera.focal_length_px;
    check(focal.into_iter().all(is_length), "camera.focal_length_px", focal, "two lengths above 0 px")?;
    let point = camera.principal_point_px;
    check(are_finite(&point), "camera.principal_point_px", point, "two finite numbers, px")?;
    let lens = camera.distortion;
    for (key, value) in [("k1", lens.k1), ("k2", lens.k2), ("p1", lens.p1), ("p2", lens.p2)] {
        check(value.is_finite(), &format!("camera.distortion.{key}"), value, "a finite number")?;
    }
    let rotation = camera.rotation_rad;
    check(are_finite(&rotation), "camera.rotation_rad", rotation, "three finite angles, rad")?;
    let translation = camera.translation_mm;
    let is_ahead = are_finite(&translation) && translation[2] > 0.0;
    check(is_ahead, "camera.translation_mm", translation, "three finite lengths, the last above 0 mm")
}

fn validate_gel(gel: &GelSection) -> Result<(), ProfileError> {
    check(gel.size_mm.into_iter().all(is_length), "gel.size_mm", gel.size_mm, "two lengths above 0 mm")?;
    check(is_length(gel.thickness_mm), "gel.thickness_mm", gel.thickness_mm, "a length above 0 mm")?;
    let nu = gel.poissons_ratio;
    check((0.0..0.5).contains(&nu), "gel.poissons_ratio", nu, "at least 0 and below 0.5")?;
    let Some(modulus) = gel.youngs_modulus_mpa else { return Ok(()) };
    check(is_length(modulus), "gel.youngs_modulus_mpa", modulus, "a finite stiffness above 0 MPa")
}

fn is_length(value: f64) -> bool {
    value.is_finite() && value > 0.0
}

fn are_finite(values: &[f64]) -> bool {
    values.iter().all(|value| value.is_finite())
}

fn check(holds: bool, key: &str, value: impl Debug, allowed: &str) -> Result<(), ProfileError> {
    if holds { Ok(()) } else { Err(SettingsError::out_of_range(key, value, allowed).into()) }
}

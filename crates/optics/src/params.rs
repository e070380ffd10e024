//! The parameters of a camera, and their possible values.

use std::fmt::Debug;

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A camera and its pose.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraParams {
    /// Focal length along x and y, px.
    pub focal_length_px: [f64; 2],
    /// The principal point, where the optical axis meets the image, px in the region of interest.
    pub principal_point_px: [f64; 2],
    /// The distortion of the lens.
    #[serde(default)]
    pub distortion: Distortion,
    /// Rotation of the gel in camera space as a rotation vector: its direction the axis, its length the angle, rad.
    ///
    /// It acts after the reflection that turns gel space's z around: see the crate's documentation.
    #[serde(default)]
    pub rotation_rad: [f64; 3],
    /// The gel's origin, the centre of its undeformed surface, in camera space, mm.
    pub translation_mm: [f64; 3],
}

/// Brown's radial and tangential distortion, dimensionless; zero is a pinhole.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Distortion {
    /// Radial, with the square of the distance from the axis.
    pub k1: f64,
    /// Radial, with the fourth power of the distance from the axis, or as given by [`Distortion::radial`].
    pub k2: f64,
    /// Tangential, along y.
    pub p1: f64,
    /// Tangential, along x.
    pub p2: f64,
    /// The polynomial of the radial part.
    #[serde(skip_serializing_if = "Radial::is_brown")]
    pub radial: Radial,
}

/// The factor by which the distance r from the axis is stretched, r dimensionless.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Radial {
    /// Brown's `1 + k1 r² + k2 r⁴`.
    #[default]
    Brown,
    /// `1 + k1 r² + k2 r`, as printed in [Du2021](https://doi.org/10.1109/LRA.2021.3061306).
    Printed,
}

impl Radial {
    #[expect(clippy::trivially_copy_pass_by_ref, reason = "the signature that serde calls")]
    fn is_brown(&self) -> bool {
        *self == Self::Brown
    }
}

/// A camera that is impossible, or that does not see the gel.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{key} = {value} is impossible: it must be {allowed}")]
pub struct CameraError {
    /// Which value, by its path in the file's `[camera]` table.
    pub key: &'static str,
    /// The value.
    pub value: String,
    /// The possible values, with their unit.
    pub allowed: &'static str,
}

impl CameraParams {
    /// Checks each value alone.
    pub(crate) fn check_values(&self) -> Result<(), CameraError> {
        let focal = self.focal_length_px;
        let is_length = |value: f64| value.is_finite() && value > 0.0;
        check(focal.into_iter().all(is_length), "focal_length_px", focal, "two lengths above 0 px")?;
        let point = self.principal_point_px;
        check(are_finite(&point), "principal_point_px", point, "two finite numbers, px")?;
        let lens = self.distortion;
        let coefficients = [
            ("distortion.k1", lens.k1),
            ("distortion.k2", lens.k2),
            ("distortion.p1", lens.p1),
            ("distortion.p2", lens.p2),
        ];
        for (key, value) in coefficients {
            check(value.is_finite(), key, value, "a finite number")?;
        }
        let rotation = self.rotation_rad;
        check(are_finite(&rotation), "rotation_rad", rotation, "three finite angles, rad")?;
        let translation = self.translation_mm;
        let is_ahead = are_finite(&translation) && translation[2] > 0.0;
        check(is_ahead, "translation_mm", translation, "three finite lengths, the last above 0 mm")
    }
}

fn are_finite(values: &[f64]) -> bool {
    values.iter().all(|value| value.is_finite())
}

pub(crate) fn check(
    holds: bool,
    key: &'static str,
    value: impl Debug,
    allowed: &'static str,
) -> Result<(), CameraError> {
    if holds { Ok(()) } else { Err(CameraError { key, value: format!("{value:?}"), allowed }) }
}

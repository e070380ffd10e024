//! The tables of a scene file that also occur in a profile or in the mechanics. Here missing values are those of the
//! simulated sensor.

use fingervision_elastic::{ContactLaw, GelBlock, Law};
use fingervision_optics::{CameraParams, Distortion};
use serde::{Deserialize, Serialize};

/// The `[camera]` table: how the camera sees the gel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CameraTable {
    /// Focal length along x and y, px.
    pub focal_length_px: [f64; 2],
    /// Where the optical axis meets the image, px; absent: its centre.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub principal_point_px: Option<[f64; 2]>,
    /// The distortion of the lens.
    pub distortion: Distortion,
    /// Rotation of the gel in camera space as a rotation vector, rad.
    pub rotation_rad: [f64; 3],
    /// The gel's origin in camera space, mm.
    pub translation_mm: [f64; 3],
}

impl Default for CameraTable {
    /// 25 mm from the surface, upright, without distortion.
    fn default() -> Self {
        Self {
            focal_length_px: [400.0; 2],
            principal_point_px: None,
            distortion: Distortion::default(),
            rotation_rad: [0.0; 3],
            translation_mm: [0.0, 0.0, 25.0],
        }
    }
}

impl CameraTable {
    /// The camera for images of this many columns and rows, px.
    pub(super) fn params(&self, (width, height): (usize, usize)) -> CameraParams {
        let centre = [width, height].map(|pixels| 0.5 * (pixels as f64 - 1.0));
        CameraParams {
            focal_length_px: self.focal_length_px,
            principal_point_px: self.principal_point_px.unwrap_or(centre),
            distortion: self.distortion,
            rotation_rad: self.rotation_rad,
            translation_mm: self.translation_mm,
        }
    }
}

/// The `[gel]` table.
#[derive(Serialize, Deserialize)]
#[serde(remote = "GelBlock", default = "default_gel", deny_unknown_fields)]
pub(super) struct GelTable {
    size_mm: [f64; 2],
    thickness_mm: f64,
    poissons_ratio: f64,
    youngs_modulus_mpa: Option<f64>,
}

/// The default simulated sensor's gel.
pub(super) fn default_gel() -> GelBlock {
    GelBlock { size_mm: [30.0; 2], thickness_mm: 10.0, poissons_ratio: 0.48, youngs_modulus_mpa: Some(0.6) }
}

/// The `[material]` table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MaterialTable {
    /// The material law: `"neo-hookean"` or `"linear"`.
    pub law: Law,
}

/// The `[contact]` table.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ContactTable {
    /// The contact law between gel and indenter: `"stick"`, `"late-stick"`, `"frictionless"` or `{ friction = 0.8 }`.
    pub law: ContactLaw,
}

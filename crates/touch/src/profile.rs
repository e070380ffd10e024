//! The profile: one file that describes one sensor.
//!
//! Every part but the algorithms' parameters may be absent, which switches off what needs it: without `[image]` the
//! whole frame is used, without a depth line there is no depth. Lengths are in mm, positions in the image in px of the
//! region of interest.
//!
//! ```
//! use fingervision_touch::Profile;
//!
//! let mut profile = Profile::from_toml("name = 'left index'\n[density]\nsigma_px = 2.5")?;
//! profile.set("flow.finest_level", "1")?;
//! assert_eq!(profile.flow.finest_level, Some(1));
//! # Ok::<(), fingervision_touch::ProfileError>(())
//! ```

mod error;
#[cfg(test)]
mod tests;
mod validate;

use std::path::Path;

use fingervision_flow::FlowParams;
use fingervision_image::Rect;
use fingervision_settings::Document;
use serde::{Deserialize, Serialize};

use crate::{DensityParams, DepthLine, ReferenceParams};

pub use error::ProfileError;

const PROFILE: Document = Document::new("profile");

/// One sensor: what it is made of, how it was calibrated and how it is read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Profile {
    /// What its owner calls the sensor.
    pub name: String,
    /// Which part of the camera image shows the gel; absent: all of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub image: Option<ImageSection>,
    /// How the camera sees the gel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraSection>,
    /// What the gel is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gel: Option<GelSection>,
    /// How depth is found.
    pub depth: DepthSection,
    /// Parameters of the flow.
    pub flow: FlowParams,
    /// Parameters of the references.
    pub references: ReferenceParams,
    /// Parameters of the density and its filter.
    pub density: DensityParams,
}

/// The gel's place in the camera image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImageSection {
    /// Left column, top row, width and height of the region of interest, px.
    pub region_of_interest: [usize; 4],
}

/// The camera and its pose.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraSection {
    /// Focal length along x and y, px.
    pub focal_length_px: [f64; 2],
    /// Where the optical axis meets the image, px in the region of interest.
    pub principal_point_px: [f64; 2],
    /// How the lens bends rays.
    #[serde(default)]
    pub distortion: Distortion,
    /// Rotation of the gel in camera space as a rotation vector: its direction the axis, its length the angle, rad.
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
    /// Radial, with the fourth power of the distance from the axis.
    pub k2: f64,
    /// Tangential, along y.
    pub p1: f64,
    /// Tangential, along x.
    pub p2: f64,
}

/// The gel's size and material.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GelSection {
    /// Extent along x and y, mm.
    pub size_mm: [f64; 2],
    /// Distance from the surface to the rigid base, mm.
    pub thickness_mm: f64,
    /// Poisson's ratio, dimensionless: 0 is cork, just below 0.5 is rubber.
    pub poissons_ratio: f64,
    /// Young's modulus, `MPa`; without it there is no force.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub youngs_modulus_mpa: Option<f64>,
}

/// How depth is found.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DepthSection {
    /// The method.
    pub method: DepthMethod,
    /// The line from the density feature to depth; without it the density gives no depth.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density: Option<DepthLine>,
}

/// A way to find depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DepthMethod {
    /// The fitted line of the density feature, if there is one.
    #[default]
    Density,
    /// The gel's elasticity, from the flow.
    Elastic,
}

impl Default for Profile {
    /// A sensor that nothing is known about: tracked over the whole image, without depth.
    fn default() -> Self {
        Self {
            name: "unnamed".into(),
            image: None,
            camera: None,
            gel: None,
            depth: DepthSection::default(),
            flow: FlowParams::default(),
            references: ReferenceParams::default(),
            density: DensityParams::default(),
        }
    }
}

impl Profile {
    /// Reads a profile from a file.
    ///
    /// # Errors
    ///
    /// [`ProfileError`] with the file's name, and with the line where one is to blame.
    pub fn load(path: &Path) -> Result<Self, ProfileError> {
        let text = PROFILE.read(path)?;
        Self::from_toml(&text).map_err(|error| error.in_file(path))
    }

    /// Reads a profile from the text of its file.
    ///
    /// # Errors
    ///
    /// [`ProfileError::Settings`] with its line, or whatever [`Profile::validate`] finds.
    pub fn from_toml(text: &str) -> Result<Self, ProfileError> {
        let profile: Self = PROFILE.parse(text)?;
        profile.validate().map_err(|error| error.in_text(text))?;
        Ok(profile)
    }

    /// The profile as the text of a file, every default written out.
    #[must_use]
    pub fn to_toml(&self) -> String {
        PROFILE.to_text(self)
    }

    /// Sets one value by its path, as in `flow.finest_level` to `1`.
    ///
    /// `value_text` is read as TOML; a word that is no TOML value is taken as a string. Tables on the way are made.
    ///
    /// # Errors
    ///
    /// As [`Profile::set_all`].
    pub fn set(&mut self, path: &str, value_text: &str) -> Result<(), ProfileError> {
        self.set_all([(path, value_text)])
    }

    /// Sets several values by their paths, all before any is checked: a table whose keys belong together can be given
    /// key by key. After an error the profile is as it was.
    ///
    /// # Errors
    ///
    /// [`ProfileError::Settings`] naming the path, or whatever [`Profile::validate`] finds.
    pub fn set_all<'a>(
        &mut self,
        assignments: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<(), ProfileError> {
        let changed = PROFILE.with_assignments(self, assignments)?;
        changed.validate()?;
        *self = changed;
        Ok(())
    }

    /// Checks that every value is possible.
    ///
    /// # Errors
    ///
    /// [`SettingsError::OutOfRange`](fingervision_settings::SettingsError::OutOfRange) naming the first value that is not.
    pub fn validate(&self) -> Result<(), ProfileError> {
        validate::validate(self)
    }

    /// The region of interest in frames of this size, px: the whole frame if the profile names none.
    ///
    /// # Errors
    ///
    /// [`ProfileError::RegionOutside`] if the region reaches outside the frame.
    pub fn region(&self, (width, height): (usize, usize)) -> Result<Rect, ProfileError> {
        let Some(ImageSection { region_of_interest: [x, y, columns, rows] }) = self.image else {
            return Ok(Rect::whole(width, height));
        };
        let region = Rect { x, y, width: columns, height: rows };
        if region.is_inside(width, height) {
            Ok(region)
        } else {
            Err(ProfileError::RegionOutside { region, frame_size: (width, height) })
        }
    }

    /// Size of a pixel on the undeformed surface where the optical axis meets it, mm; absent without a camera.
    #[must_use]
    pub fn mm_per_px(&self) -> Option<f64> {
        let camera = self.camera?;
        let [fx, fy] = camera.focal_length_px;
        Some(camera.translation_mm[2] / (fx * fy).sqrt())
    }
}

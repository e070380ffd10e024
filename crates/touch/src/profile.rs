//! The profile: one file that describes one sensor.
//!
//! Every part except the algorithms' parameters may be absent; the quantities that need it are then not computed.
//! Without `[image]` the whole frame is used. Depth needs either camera and gel or a depth law. Lengths are in mm,
//! positions in the image in px of the region of interest.
//!
//! ```
//! use fingervision_touch::Profile;
//!
//! let mut profile = Profile::from_toml("name = 'left index'\n[density]\nsigma_px = 2.5")?;
//! profile.set("flow.finest_level", "1")?;
//! assert_eq!(profile.flow.finest_level, Some(1));
//! # Ok::<(), fingervision_touch::ProfileError>(())
//! ```

mod capture;
mod effect;
mod error;
mod remarks;
#[cfg(test)]
mod remarks_tests;
mod review;
mod run_record;
#[cfg(test)]
mod tests;
mod validate;
mod view;

use std::path::Path;

use fingervision_elastic::GelBlock;
use fingervision_flow::FlowParams;
use fingervision_image::Rect;
use fingervision_optics::{Camera, CameraParams};
use fingervision_settings::Document;
use serde::{Deserialize, Serialize};

use crate::{DensityParams, DepthLaw, ElasticParams, Fingerprint, ReferenceParams};

pub use capture::CaptureSection;
pub use error::ProfileError;
pub use remarks::{Remark, Weight};
pub use review::ProfileReview;
use run_record::RunRecord;

const PROFILE: Document = Document::new("profile");

/// The profile of the documentation.
#[cfg(test)]
const SENSOR: &str = "
    [image]
    region_of_interest = [15, 15, 610, 450]
    [camera]
    focal_length_px = [400.0, 400.0]
    principal_point_px = [304.5, 224.5]
    translation_mm = [0.0, 0.0, 25.0]
    [gel]
    size_mm = [30.0, 30.0]
    thickness_mm = 10.0
    poissons_ratio = 0.48
    youngs_modulus_mpa = 0.6
";

/// One sensor: its parts, its calibration and the parameters of tracking.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Profile {
    /// The name of the sensor.
    pub name: String,
    /// The sensor's camera and its settings; used only if the frames come from a camera.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub capture: Option<CaptureSection>,
    /// The part of the camera image that shows the gel; if absent, the whole image.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub image: Option<ImageSection>,
    /// The camera.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraParams>,
    /// The gel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gel: Option<GelBlock>,
    /// The fingerprint of the pattern.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pattern: Option<PatternSection>,
    /// How depth is computed.
    pub depth: DepthSection,
    /// Parameters of the flow.
    pub flow: FlowParams,
    /// Parameters of the references.
    pub references: ReferenceParams,
    /// Parameters of the density and its filter.
    pub density: DensityParams,
    /// Parameters of the elastic inverse.
    pub elastic: ElasticParams,
}

/// The gel's place in the camera image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImageSection {
    /// Left column, top row, width and height of the region of interest, px.
    pub region_of_interest: [usize; 4],
}

/// The fingerprint of the pattern.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PatternSection {
    /// Distinguishes this sensor from others; if absent, the pattern is not checked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fingerprint: Option<Fingerprint>,
}

/// How depth is computed.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DepthSection {
    /// The method; if absent, the one that [`Profile::depth_method`] selects.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub method: Option<DepthMethod>,
    /// The relation between density feature and depth; without it, no depth is computed from density.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density: Option<DepthLaw>,
}

/// A method to compute depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DepthMethod {
    /// The fitted law of the density feature, if there is one.
    Density,
    /// The gel's elasticity, from the flow; needs `[camera]` and `[gel]`.
    Elastic,
}

impl DepthMethod {
    /// The method's name in a profile.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Density => "density",
            Self::Elastic => "elastic",
        }
    }
}

impl Default for Profile {
    /// A sensor without calibration: tracked over the whole image, without depth.
    fn default() -> Self {
        Self {
            name: "unnamed".into(),
            capture: None,
            image: None,
            camera: None,
            gel: None,
            pattern: None,
            depth: DepthSection::default(),
            flow: FlowParams::default(),
            references: ReferenceParams::default(),
            density: DensityParams::default(),
            elastic: ElasticParams::default(),
        }
    }
}

impl Profile {
    /// Reads a profile from a file: either a profile, or the `run.toml` of a run, of which `[profile]` is used.
    ///
    /// # Errors
    ///
    /// [`ProfileError`] with the file's name, and with the line that causes it, if there is one.
    pub fn load(path: &Path) -> Result<Self, ProfileError> {
        let text = PROFILE.read(path)?;
        Self::from_toml(&text).map_err(|error| error.in_file(path))
    }

    /// Reads a profile from the text of its file, as [`Profile::load`].
    ///
    /// # Errors
    ///
    /// [`ProfileError::Settings`] with its line, or an error of [`Profile::validate`].
    pub fn from_toml(text: &str) -> Result<Self, ProfileError> {
        let profile: Self =
            if Self::is_run_record(text) { PROFILE.parse::<RunRecord>(text)?.profile } else { PROFILE.parse(text)? };
        profile.validate().map_err(|error| error.in_text(text))?;
        Ok(profile)
    }

    /// Whether a text is that of a `run.toml`, which contains the profile in force in a table of its own.
    #[must_use]
    pub fn is_run_record(text: &str) -> bool {
        run_record::is_run_record(text)
    }

    /// The profile as the text of a file, every default written out.
    #[must_use]
    pub fn to_toml(&self) -> String {
        PROFILE.to_text(self)
    }

    /// Sets one value by its path, as in `flow.finest_level` to `1`.
    ///
    /// `value_text` is read as TOML; a word that is not a TOML value is taken as a string. Missing tables are created.
    ///
    /// # Errors
    ///
    /// As [`Profile::set_all`].
    pub fn set(&mut self, path: &str, value_text: &str) -> Result<(), ProfileError> {
        self.set_all([(path, value_text)])
    }

    /// Sets several values by their paths and checks them together: keys of a table that depend on each other can be
    /// given one by one. After an error the profile is unchanged.
    ///
    /// # Errors
    ///
    /// [`ProfileError::Settings`] naming the path, or an error of [`Profile::validate`].
    pub fn set_all<'a>(
        &mut self,
        assignments: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<(), ProfileError> {
        self.assign(&assignments.into_iter().collect::<Vec<_>>())
    }

    /// As [`Self::set_all`], compiled here and not again for every kind of iterator.
    fn assign(&mut self, assignments: &[(&str, &str)]) -> Result<(), ProfileError> {
        let changed = PROFILE.with_assignments(self, assignments)?;
        changed.validate()?;
        *self = changed;
        Ok(())
    }

    /// The settings to capture this sensor, with this camera instead of the profile's if one is given.
    #[must_use]
    pub fn capture_from(&self, camera: Option<&str>) -> CaptureSection {
        let section = self.capture.clone().unwrap_or_default();
        CaptureSection { camera: camera.map(Into::into).or(section.camera), ..section }
    }

    /// Checks that every value is possible.
    ///
    /// # Errors
    ///
    /// [`SettingsError::OutOfRange`](fingervision_settings::SettingsError::OutOfRange) naming the first value that is
    /// not.
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

    /// The method in force: the value of `depth.method`; without it elastic if camera and gel are known, otherwise
    /// density.
    #[must_use]
    pub fn depth_method(&self) -> DepthMethod {
        let is_known = self.camera.is_some() && self.gel.is_some();
        self.depth.method.unwrap_or(if is_known { DepthMethod::Elastic } else { DepthMethod::Density })
    }

    /// Camera and gel, which the elastic inverse needs.
    ///
    /// # Errors
    ///
    /// [`ProfileError::ElasticNeeds`] naming the first table that is absent; [`ProfileError::Settings`] if the camera
    /// is impossible.
    pub fn elastic_sensor(&self) -> Result<(Camera, GelBlock), ProfileError> {
        let absent = |table| ProfileError::ElasticNeeds { table };
        let params = self.camera.ok_or(absent("camera"))?;
        let gel = self.gel.ok_or(absent("gel"))?;
        Ok((Camera::new(&params).map_err(validate::impossible_camera)?, gel))
    }

    /// The fingerprint of the sensor's pattern, if it is known.
    #[must_use]
    pub fn fingerprint(&self) -> Option<Fingerprint> {
        self.pattern.and_then(|pattern| pattern.fingerprint)
    }

    /// Whether the method is elastic and camera and gel are known.
    fn has_elastic_depth(&self) -> bool {
        self.depth_method() == DepthMethod::Elastic && self.elastic_sensor().is_ok()
    }

    /// Whether gel and camera are outside the training range of the network behind elastic depth; absent without it.
    fn is_outside_training_range(&self) -> Option<bool> {
        let is_used = self.has_elastic_depth() && self.elastic.network;
        let outside = |(camera, gel)| self.elastic.is_outside_training(&camera, &gel);
        is_used.then(|| self.elastic_sensor().is_ok_and(outside))
    }

    /// Size of a pixel on the undeformed surface where the optical axis meets it, mm; absent without a camera.
    #[must_use]
    pub fn mm_per_px(&self) -> Option<f64> {
        let params = self.camera?;
        Camera::new(&params).ok()?.mm_per_px(params.principal_point_px)
    }
}

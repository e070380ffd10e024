//! The simulated sensors: the paper's, with the values given in its text, and the default one.

use fingervision_gel::{Scene, SceneError};
use serde::Serialize;

use crate::experiment::Extent;

/// A simulated sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Setting {
    /// With the values given in the paper's text: Poisson's ratio 0.35, 99×99×10 cells, 480×480 px, the camera at half
    /// the gel's width. The text gives no contact law and no focal length: contact sticks here, and the gel fills the
    /// image.
    Published,
    /// The default simulated sensor: Poisson's ratio 0.48, the camera 25 mm away, sticking.
    Realistic,
}

impl Extent {
    /// Number of parts to compute.
    #[must_use]
    pub fn parts(self) -> u64 {
        5 + 2 * self.settings().len() as u64
    }

    /// The sensors that are simulated.
    pub(super) fn settings(self) -> &'static [Setting] {
        match self {
            Self::Full => &[Setting::Published, Setting::Realistic],
            Self::Quick => &[Setting::Realistic],
        }
    }

    /// The indenters of figures 4, 6 and 7.
    pub(super) fn indenters(self) -> &'static [&'static str] {
        match self {
            Self::Full => &["circle", "triangle", "rectangle", "crossing"],
            Self::Quick => &["circle", "crossing"],
        }
    }
}

impl Setting {
    /// Its name in headings.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Published => "the paper's setting",
            Self::Realistic => "the default sensor",
        }
    }

    /// The name in links.
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Published => "published",
            Self::Realistic => "realistic",
        }
    }

    /// A description.
    pub(super) fn about(self) -> &'static str {
        match self {
            Self::Published => {
                "480×480 px, Poisson's ratio 0.35, 99×99×10 cells under the indenters (the calibration presses on a draft mesh), \
                 the camera 15 mm from a gel of 30×30×10 mm with a focal length of 240 px, sticking contact, 2 mm deep"
            }
            Self::Realistic => {
                "480×480 px, Poisson's ratio 0.48, 0.3 mm cells under the indenters (the calibration presses on a draft mesh), the \
                 camera 25 mm from a gel of 30×30×10 mm with a focal length of 400 px, sticking contact, 2 mm deep"
            }
        }
    }

    /// A scene on this sensor, on a draft mesh.
    pub(super) fn draft(self, mut scene: Scene, extent: Extent) -> Result<Scene, SceneError> {
        if self == Self::Published {
            scene.set_all([
                ("gel.poissons_ratio", "0.35"),
                ("camera.focal_length_px", "[240.0, 240.0]"),
                ("camera.translation_mm", "[0.0, 0.0, 15.0]"),
            ])?;
        }
        scene.make_draft();
        extent.shorten(&mut scene)?;
        Ok(scene)
    }

    /// A scene on this sensor, on the mesh for the figures.
    pub(super) fn scene(self, scene: Scene, extent: Extent) -> Result<Scene, SceneError> {
        let mut scene = self.draft(scene, extent)?;
        match (extent, self) {
            (Extent::Quick, _) => {}
            (Extent::Full, Self::Published) => scene.set_all([("mesh.cells", "[99, 99, 10]")])?,
            (Extent::Full, Self::Realistic) => scene.set_all([("mesh.resolution", "\"fine\"")])?,
        }
        Ok(scene)
    }
}

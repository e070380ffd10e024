//! The simulated sensors: the paper's, with the values given in its text, and the default one.

use std::collections::BTreeSet;

use fingervision_calibrate::depth::Place;
use fingervision_gel::{ContactLaw, Resolution, Scene, SceneError};
use serde::Serialize;

use crate::experiment::{CALIBRATION, Extent};

/// A simulated sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Setting {
    /// As far as the paper's text fixes it: Poisson's ratio 0.35, 99×99×10 cells, 480×480 px, the camera at half the
    /// gel's width. Contact law and focal length are not printed: sticking, and such that the gel fills the image.
    Published,
    /// The default simulated sensor: Poisson's ratio 0.48, the camera 25 mm away, sticking.
    Realistic,
}

impl Extent {
    /// How many parts there are to make.
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

    /// A word for anchors.
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Published => "published",
            Self::Realistic => "realistic",
        }
    }

    /// What it is, read from the scenes that are solved.
    pub(super) fn about(self, extent: Extent) -> Result<String, SceneError> {
        let scene = |name: &&str| self.scene(Scene::find(name)?, extent);
        let indenters = extent.indenters().iter().map(scene).collect::<Result<Vec<_>, _>>()?;
        let press = |(name, _): &(&str, Place)| self.draft(Scene::find(name)?, extent);
        let presses = CALIBRATION.iter().map(press).collect::<Result<Vec<_>, _>>()?;
        let Scene { render, gel, camera, contact, .. } = &presses[0];
        let ([width, height], thickness, ratio) = (gel.size_mm, gel.thickness_mm, gel.poissons_ratio);
        let poses = indenters.iter().flat_map(|scene| scene.motion.poses());
        let deepest_mm = poses.map(|pose| pose.depth_mm).fold(0.0, f64::max);
        let frames = presses.iter().map(|press| press.motion.frames);
        let frames = [frames.clone().min(), frames.max()].map(Option::unwrap_or_default);
        let frames =
            if frames[0] == frames[1] { frames[0].to_string() } else { format!("{} to {}", frames[0], frames[1]) };
        let meshes = |scenes: &[Scene]| {
            let meshes: BTreeSet<String> = scenes.iter().map(mesh).collect();
            meshes.into_iter().collect::<Vec<_>>().join(" or ")
        };
        Ok(format!(
            "{}×{} px, Poisson's ratio {ratio}, {frames} frames a press, {} under the calibration presses, {} under the indenters, which \
             go up to {deepest_mm} mm deep, the camera {} mm from a gel of {width}×{height}×{thickness} mm with a focal length of {} \
             px, {}",
            render.width,
            render.height,
            meshes(&presses),
            meshes(&indenters),
            camera.translation_mm[2],
            camera.focal_length_px[0],
            contact_law(contact.law)
        ))
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

    /// A scene on this sensor, on the mesh that the figures are made with.
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

/// The mesh of a scene in words.
fn mesh(scene: &Scene) -> String {
    match (scene.mesh.cells, scene.mesh.resolution) {
        (Some([x, y, z]), _) => format!("{x}×{y}×{z} cells"),
        (None, Resolution::Fine) => "a fine mesh".into(),
        (None, Resolution::Medium) => "a medium mesh".into(),
        (None, Resolution::Draft) => "a draft mesh".into(),
    }
}

fn contact_law(law: ContactLaw) -> String {
    match law {
        ContactLaw::Stick => "sticking contact".into(),
        ContactLaw::LateStick => "contact that sticks after a step".into(),
        ContactLaw::Frictionless => "contact without friction".into(),
        ContactLaw::Friction(coefficient) => format!("contact with a friction of {coefficient}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_setting_is_described_by_the_scenes_that_are_solved() {
        for (extent, expected) in [
            (
                Extent::Quick,
                "11 frames a press, a draft mesh under the calibration presses, a draft mesh under the indenters",
            ),
            (
                Extent::Full,
                "11 to 31 frames a press, a draft mesh under the calibration presses, a fine mesh under the indenters",
            ),
        ] {
            let about = Setting::Realistic.about(extent).unwrap();
            assert!(about.starts_with("480×480 px, Poisson's ratio 0.48, ") && about.contains(expected), "{about}");
            assert!(
                about.contains("the camera 25 mm from a gel of 30×30×10 mm with a focal length of 400 px"),
                "{about}"
            );
        }
        let about = Setting::Published.about(Extent::Full).unwrap();
        assert!(about.contains("ratio 0.35") && about.contains("99×99×10 cells under the indenters"), "{about}");
    }
}

//! The cases of the benchmark: scenes × variations.

use fingervision_gel::{MeshParams, Resolution, Scene, SceneError};
use serde::Serialize;

use crate::experiment::Extent;
use crate::press_options::ready_made_presses;

/// A change of the default sensor, or of the contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Variation {
    /// Its name, which is a part of the case's name.
    pub name: &'static str,
    /// Its description.
    pub about: &'static str,
    /// Paths of the scene and their values.
    #[serde(skip)]
    assignments: &'static [(&'static str, &'static str)],
    /// The variation whose calibration it uses: one with the same sensor.
    #[serde(skip)]
    pub(super) sensor: &'static str,
    /// Whether the variation also applies to a pattern of dots.
    #[serde(skip)]
    pub(super) has_dots: bool,
}

const fn variation(
    name: &'static str,
    about: &'static str,
    assignments: &'static [(&'static str, &'static str)],
    sensor: &'static str,
    has_dots: bool,
) -> Variation {
    Variation { name, about, assignments, sensor, has_dots }
}

impl Variation {
    /// All of them, the default sensor first.
    pub const ALL: &'static [Self] = &[
        variation(
            "default",
            "Poisson's ratio 0.48, sticking contact, noise of 2 levels, cells of 0.1 mm",
            &[],
            "default",
            true,
        ),
        variation("nu-0.35", "Poisson's ratio 0.35", &[("gel.poissons_ratio", "0.35")], "nu-0.35", true),
        variation("frictionless", "frictionless contact", &[("contact.law", "\"frictionless\"")], "default", true),
        variation(
            "nu-0.35-frictionless",
            "Poisson's ratio 0.35, frictionless contact",
            &[("gel.poissons_ratio", "0.35"), ("contact.law", "\"frictionless\"")],
            "nu-0.35",
            true,
        ),
        variation("noise-5", "noise of 5 levels", &[("render.noise_levels", "5.0")], "noise-5", true),
        variation(
            "uneven-light",
            "shading up to 30 %, 40 % darker corners",
            &[("render.shading", "0.3"), ("render.vignetting", "0.4")],
            "uneven-light",
            true,
        ),
        variation("cells-0.2mm", "cells of 0.2 mm", &[("pattern.cell_mm", "0.2")], "cells-0.2mm", false),
    ];

    /// The variation of this name.
    #[must_use]
    pub fn find(name: &str) -> Option<&'static Self> {
        Self::ALL.iter().find(|variation| variation.name == name)
    }

    /// A scene under this variation.
    ///
    /// # Errors
    ///
    /// [`SceneError`] if it is impossible.
    pub fn apply(&self, mut scene: Scene) -> Result<Scene, SceneError> {
        scene.set_all(self.assignments.iter().copied())?;
        Ok(scene)
    }
}

/// A scene under a variation.
#[derive(Debug, Clone)]
pub struct Case {
    /// The scene's name and the variation's, joined by two hyphens.
    pub name: String,
    /// The scene before it was varied.
    pub base: &'static str,
    /// The variation.
    pub variation: &'static Variation,
    /// The scene that is simulated.
    pub scene: Scene,
}

/// Every case, on meshes of this resolution. Truth and images come from the same mesh, so any resolution can be used.
///
/// # Errors
///
/// [`SceneError`] if a scene is impossible under a variation.
pub fn cases(extent: Extent, mesh: Resolution) -> Result<Vec<Case>, SceneError> {
    let is_asked = |name: &str| extent == Extent::Full || ["circle", "sphere", "letter"].contains(&name);
    let variations = if extent == Extent::Full { Variation::ALL } else { &Variation::ALL[..1] };
    let scenes = ready_made_presses().filter(|ready| is_asked(ready.name));
    let mut cases = Vec::new();
    for ready in scenes {
        for variation in variations {
            let mut scene = variation.apply(ready.scene())?;
            adapt(&mut scene, extent, mesh)?;
            scene.name = format!("{}--{}", ready.name, variation.name);
            cases.push(Case { name: scene.name.clone(), base: ready.name, variation, scene });
        }
    }
    Ok(cases)
}

/// The settings with which a scene of this extent is solved and drawn.
pub(super) fn adapt(scene: &mut Scene, extent: Extent, resolution: Resolution) -> Result<(), SceneError> {
    scene.mesh = MeshParams { resolution, ..MeshParams::default() };
    extent.shorten(scene)
}

#[cfg(test)]
mod tests {
    use fingervision_gel::ReadyMade;

    use super::*;

    #[test]
    fn every_press_is_varied_in_every_way() {
        let all = cases(Extent::Full, Resolution::Draft).unwrap();
        assert_eq!(all.len(), 13 * Variation::ALL.len());
        let mut names: Vec<_> = all.iter().map(|case| &case.name).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), all.len(), "every case has a name of its own");
        for case in &all {
            assert!(Variation::find(case.variation.sensor).is_some(), "{}", case.name);
        }
    }

    #[test]
    fn a_quick_case_goes_as_deep() {
        for case in cases(Extent::Quick, Resolution::Draft).unwrap() {
            let [full, quick] = [ReadyMade::find(case.base).unwrap().scene(), case.scene].map(|scene| {
                let poses = scene.motion.poses();
                (poses.len(), poses.last().unwrap().depth_mm)
            });
            assert!((full.1 - quick.1).abs() < 1e-12 && quick.0 == 11, "{}: {full:?} {quick:?}", case.name);
        }
    }
}

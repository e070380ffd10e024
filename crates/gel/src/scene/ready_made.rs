//! The scenes that come with the program.

use super::Scene;

/// A scene that comes with the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReadyMade {
    /// Its name.
    pub name: &'static str,
    /// Its file.
    pub text: &'static str,
}

/// Lists scenes by their files' names.
macro_rules! scenes {
    ($($name:literal),+ $(,)?) => {
        [$(ReadyMade { name: $name, text: include_str!(concat!("../../scenes/", $name, ".toml")) }),+]
    };
}

const SCENES: [ReadyMade; 23] = scenes![
    "circle",
    "rectangle",
    "triangle",
    "crossing",
    "sphere",
    "ring",
    "letter",
    "tilt",
    "pins",
    "corner",
    "press-then-shear",
    "press-then-twist",
    "slip",
    "calibration-centre-1mm",
    "calibration-centre-2mm",
    "calibration-centre-3mm",
    "calibration-midway-1mm",
    "calibration-midway-2mm",
    "calibration-midway-3mm",
    "calibration-corner-1mm",
    "calibration-corner-2mm",
    "calibration-corner-3mm",
    "board",
];

impl ReadyMade {
    /// Every scene that comes with the program.
    pub const ALL: &'static [Self] = &SCENES;

    /// The scene of this name.
    #[must_use]
    pub fn find(name: &str) -> Option<&'static Self> {
        Self::ALL.iter().find(|scene| scene.name == name)
    }

    /// The scene itself.
    ///
    /// # Panics
    ///
    /// Never: every ready-made scene can be read.
    #[must_use]
    pub fn scene(&self) -> Scene {
        Scene::from_toml(self.text).expect("every ready-made scene can be read")
    }
}

/// All names.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    ReadyMade::ALL.iter().map(|scene| scene.name)
}

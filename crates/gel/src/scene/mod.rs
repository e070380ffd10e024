//! Scenes: files that describe indenter, motion, camera and rendering; ready-made and random scenes; their solution and
//! rendering.
//!
//! A [`Scene`] is read from TOML. Missing values are those of the default simulated sensor: a gel of 30×30×10 mm seen
//! from 25 mm by 480×480 px. [`Simulation`] solves the press, with a [`PressCache`], and returns frames with their
//! truth.

mod cache;
mod error;
mod files;
mod motion;
mod random;
mod ready_made;
mod rigid;
mod simulation;
mod solve;
#[cfg(test)]
mod stub;
mod tables;
#[cfg(test)]
mod tests;
mod validate;

use std::path::Path;

use fingervision_elastic::{GelBlock, MeshParams, Resolution};
use fingervision_optics::CameraParams;
use fingervision_settings::Document;
use serde::{Deserialize, Serialize};

use crate::{Indenter, Pattern, RenderParams};

pub use cache::{CacheError, CacheSize, PressCache};
pub use error::SceneError;
pub use motion::{Keyframe, MotionKind, SceneMotion};
pub use random::RandomScenes;
pub use ready_made::ReadyMade;
pub use simulation::Simulation;
pub use solve::{EarlyEnd, Origin, Progress, SolvedPress};
pub use tables::{CameraTable, ContactTable, MaterialTable};

const SCENE: Document = Document::new("scene");

/// A simulated press: the sensor, the indenter and the camera.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Scene {
    /// The name of the scene.
    pub name: String,
    /// A description in one line.
    pub about: String,
    /// The camera.
    pub camera: CameraTable,
    /// The gel.
    #[serde(with = "tables::GelTable")]
    pub gel: GelBlock,
    /// Its material law.
    pub material: MaterialTable,
    /// The contact law.
    pub contact: ContactTable,
    /// The indenter.
    pub indenter: Indenter,
    /// Its motion.
    pub motion: SceneMotion,
    /// The printed pattern.
    pub pattern: Pattern,
    /// Rendering options.
    pub render: RenderParams,
    /// The mesh size.
    pub mesh: MeshParams,
}

impl Default for Scene {
    /// A flat disc pressed 2 mm into the default sensor.
    fn default() -> Self {
        Self {
            name: "unnamed".into(),
            about: String::new(),
            camera: CameraTable::default(),
            gel: tables::default_gel(),
            material: MaterialTable::default(),
            contact: ContactTable::default(),
            indenter: Indenter::default(),
            motion: SceneMotion::default(),
            pattern: Pattern::default(),
            render: RenderParams::default(),
            mesh: MeshParams::default(),
        }
    }
}

impl Scene {
    /// A scene by the name of a ready-made one or of a file; a name with a slash or a dot is a file's.
    ///
    /// # Errors
    ///
    /// [`SceneError::Unknown`] if there is neither, and the errors of [`Scene::load`].
    pub fn find(name: &str) -> Result<Self, SceneError> {
        if let Some(scene) = ReadyMade::find(name) {
            return Ok(scene.scene());
        }
        let path = Path::new(name);
        if path.is_file() || name.contains(['/', '\\', '.']) {
            return Self::load(path);
        }
        Err(SceneError::Unknown { name: name.into() })
    }

    /// Reads a scene from a file. The files that it names are sought from the file's folder.
    ///
    /// # Errors
    ///
    /// [`SceneError::Settings`] with the file's name, and with the line where one is to blame.
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        let text = SCENE.read(path)?;
        let mut scene: Self = SCENE.parse(&text).map_err(|error| error.in_file(path))?;
        scene.seek_files_from(path.parent().unwrap_or(Path::new("")));
        scene.validate().map_err(|error| error.in_text(&text).in_file(path))?;
        Ok(scene)
    }

    /// Reads a scene from the text of its file. The files that it names are sought from the working folder.
    ///
    /// # Errors
    ///
    /// [`SceneError::Settings`] with the line where one is to blame.
    pub fn from_toml(text: &str) -> Result<Self, SceneError> {
        let scene: Self = SCENE.parse(text)?;
        scene.validate().map_err(|error| error.in_text(text))?;
        Ok(scene)
    }

    /// The scene as the text of a file, every default written out.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut resolved = self.clone();
        resolved.camera.principal_point_px = Some(self.camera().principal_point_px);
        SCENE.to_text(&resolved)
    }

    /// Sets values by their paths, as in `gel.poissons_ratio` to `0.35`, all before any is checked. After an error the
    /// scene is as it was.
    ///
    /// # Errors
    ///
    /// [`SceneError::Settings`] naming the path.
    pub fn set_all<'a>(&mut self, assignments: impl IntoIterator<Item = (&'a str, &'a str)>) -> Result<(), SceneError> {
        self.assign(&assignments.into_iter().collect::<Vec<_>>())
    }

    /// As [`Self::set_all`], compiled here and not again for every kind of iterator.
    fn assign(&mut self, assignments: &[(&str, &str)]) -> Result<(), SceneError> {
        let changed = SCENE.with_assignments(self, assignments)?;
        changed.validate()?;
        *self = changed;
        Ok(())
    }

    /// The camera, with its principal point in the middle of the image unless the scene says otherwise.
    #[must_use]
    pub fn camera(&self) -> CameraParams {
        self.camera.params((self.render.width, self.render.height))
    }

    /// Takes a coarse mesh, which is solved in seconds.
    pub fn make_draft(&mut self) {
        self.mesh = MeshParams { resolution: Resolution::Draft, cells: None };
    }

    /// Takes other random cells and other noise.
    pub fn set_seed(&mut self, seed: u64) {
        (self.pattern.seed, self.render.seed) = (seed, seed);
    }
}

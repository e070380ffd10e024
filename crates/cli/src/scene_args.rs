//! Options of the command line that change a scene, and how it is solved.

use fingervision_gel::{PressCache, Scene, SceneError};

use crate::profile_args::assignment;
use crate::whole_number::whole_number;

#[derive(Debug, clap::Args)]
pub(crate) struct SceneArgs {
    /// Set one value of the scene, as in `gel.poissons_ratio=0.35`; may be repeated
    ///
    /// The scene.toml of any simulation lists the keys with their values.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = assignment)]
    assignments: Vec<(String, String)>,
    /// Solve on a coarse mesh, 0.75 mm where the gel is touched: seconds instead of minutes
    #[arg(long)]
    draft: bool,
    /// Number of frames into which the motion is divided, as in 31; without it the scene's own
    #[arg(long, value_name = "N", value_parser = whole_number::<usize>)]
    frames: Option<usize>,
    /// Solve the press again, even if it was solved before, and do not keep the solution
    #[arg(long)]
    no_cache: bool,
}

impl SceneArgs {
    /// The scene with the command line's changes.
    ///
    /// # Errors
    ///
    /// [`SceneError`] if it is impossible.
    pub(crate) fn change(&self, mut scene: Scene) -> Result<Scene, SceneError> {
        if self.draft {
            scene.make_draft();
        }
        let frames = self.frames.map(|frames| frames.to_string());
        let frames = frames.iter().map(|frames| ("motion.frames", frames.as_str()));
        let assignments = self.assignments.iter().map(|(key, value)| (key.as_str(), value.as_str()));
        scene.set_all(frames.chain(assignments))?;
        Ok(scene)
    }

    /// Where solved presses are kept.
    pub(crate) fn cache(&self) -> PressCache {
        if self.no_cache { PressCache::OFF } else { PressCache::standard() }
    }
}

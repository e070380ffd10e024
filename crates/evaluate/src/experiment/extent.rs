use fingervision_gel::{Scene, SceneError};
use serde::Serialize;

/// How much is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Extent {
    /// Everything.
    #[default]
    Full,
    /// One sensor, draft meshes, a few presses in half as many frames: to see that it works.
    Quick,
}

/// Frames of a press where few must do.
const FEW_FRAMES: &str = "11";

impl Extent {
    /// Shows a scene's motion in as many frames as are wanted.
    pub(crate) fn shorten(self, scene: &mut Scene) -> Result<(), SceneError> {
        if self == Self::Quick { scene.set_all([("motion.frames", FEW_FRAMES)]) } else { Ok(()) }
    }
}

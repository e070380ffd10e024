use fingervision_gel::{Scene, SceneError};
use serde::Serialize;

/// How much is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Extent {
    /// Everything.
    #[default]
    Full,
    /// One sensor, draft meshes, a few presses in half as many frames: a quick test.
    Quick,
}

/// Frames of a press in a quick test.
const FEW_FRAMES: &str = "11";

impl Extent {
    /// Divides a scene's motion into the number of frames of this extent.
    pub(crate) fn shorten(self, scene: &mut Scene) -> Result<(), SceneError> {
        if self == Self::Quick { scene.set_all([("motion.frames", FEW_FRAMES)]) } else { Ok(()) }
    }
}

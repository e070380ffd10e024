//! Which simulated presses are measured.

use fingervision_gel::Resolution;

/// The meshes and scenes of the simulated presses that are measured.
#[derive(Debug, Clone)]
pub struct PressOptions {
    /// Resolution of the meshes. Truth and images come from the same mesh, so any resolution can be used.
    pub mesh: Resolution,
    /// The scenes to measure; all presses if empty.
    pub scenes: Vec<String>,
}

impl PressOptions {
    /// Whether the presses of this scene are measured.
    pub(crate) fn includes(&self, scene: &str) -> bool {
        self.scenes.is_empty() || self.scenes.iter().any(|asked| asked == scene)
    }
}

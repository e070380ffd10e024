//! Which simulated presses are measured.

use fingervision_gel::{ReadyMade, Resolution, SceneError};

/// The meshes and scenes of the simulated presses that are measured.
#[derive(Debug, Clone)]
pub struct PressOptions {
    /// Resolution of the meshes. Truth and images come from the same mesh, so any resolution can be used.
    pub mesh: Resolution,
    /// The scenes to measure; all presses if empty.
    pub scenes: Vec<String>,
}

impl PressOptions {
    /// Checks that every scene is a ready-made press.
    pub(crate) fn check(&self) -> Result<(), SceneError> {
        let is_known = |name: &str| ready_made_presses().any(|press| press.name == name);
        match self.scenes.iter().find(|name| !is_known(name)) {
            Some(name) => Err(SceneError::Unknown { name: name.clone() }),
            None => Ok(()),
        }
    }

    /// Whether the presses of this scene are measured.
    pub(crate) fn includes(&self, scene: &str) -> bool {
        self.scenes.is_empty() || self.scenes.iter().any(|asked| asked == scene)
    }
}

/// The ready-made scenes in which the gel is pressed, but for those of a calibration.
pub(crate) fn ready_made_presses() -> impl Iterator<Item = &'static ReadyMade> {
    ReadyMade::ALL.iter().filter(|scene| scene.name != "board" && !scene.name.starts_with("calibration-"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_press_is_refused() {
        let check = |scene: &str| PressOptions { mesh: Resolution::Draft, scenes: vec![scene.into()] }.check();
        check("circle").unwrap();
        for scene in ["no such scene", "board", "calibration-centre-1mm"] {
            assert!(check(scene).is_err_and(|error| error.to_string().contains(scene)), "{scene}");
        }
    }
}

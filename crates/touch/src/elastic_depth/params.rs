//! How depth is found from the gel's elasticity: the `[elastic]` table of a profile.

use fingervision_elastic::GelBlock;
use fingervision_optics::Camera;
use serde::{Deserialize, Serialize};

use super::network::Sensor;

/// Parameters of the elastic inverse.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ElasticParams {
    /// How long a frame may take.
    pub mode: ElasticMode,
    /// Whether contact is looked for with the help of what was learned from simulated presses; without it by the rigid
    /// motion of the face alone.
    pub network: bool,
}

/// How long a frame may take.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ElasticMode {
    /// What was learned is asked in eight mirrors and quarter turns of the gel (four if it is no square), tractions are solved
    /// for to their tolerance.
    #[default]
    Exact,
    /// What was learned is asked once, tractions take a fixed number of steps from those of the frame before.
    Live,
}

impl ElasticParams {
    /// Whether what was learned is to be used, but nothing like this gel before this camera was learned from.
    #[must_use]
    pub fn is_outside_training(&self, camera: &Camera, gel: &GelBlock) -> bool {
        let [_, _, distance_mm] = camera.position_mm();
        self.network && !Sensor::new(gel, distance_mm).is_in_training_range()
    }
}

impl Default for ElasticParams {
    fn default() -> Self {
        Self { mode: ElasticMode::default(), network: true }
    }
}

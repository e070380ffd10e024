//! Settings of depth from the gel's elasticity: the `[elastic]` table of a profile.

use fingervision_elastic::GelBlock;
use fingervision_optics::Camera;
use serde::{Deserialize, Serialize};

use super::network::Sensor;

/// Parameters of the elastic inverse.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ElasticParams {
    /// How much time a frame may take.
    pub mode: ElasticMode,
    /// Whether contact and depth are found by the network trained on simulated presses; without it only stuck flat
    /// faces are found, by their rigid motion.
    pub network: bool,
}

/// How much time a frame may take.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ElasticMode {
    /// The network is evaluated for eight mirror images and quarter turns of the gel (four if it is not square),
    /// tractions are solved to their tolerance.
    #[default]
    Exact,
    /// The network is evaluated for one orientation, tractions are solved to 3 % in at most eight steps from those of the
    /// previous frame.
    Live,
}

impl ElasticParams {
    /// Whether the network is switched on, but gel and camera are outside its training range.
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

//! How depth is found from the gel's elasticity: the `[elastic]` table of a profile.

use serde::{Deserialize, Serialize};

/// Parameters of the elastic inverse.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ElasticParams {
    /// How long a frame may take.
    pub mode: ElasticMode,
    /// Whether contact is looked for with the help of what was learned from simulated presses; without it by the rigid
    /// motion of the face alone.
    pub learned: bool,
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

impl Default for ElasticParams {
    fn default() -> Self {
        Self { mode: ElasticMode::default(), learned: true }
    }
}

//! Where the time of a frame goes.

use std::time::Instant;

/// Time of each stage of one frame, ms.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StageTimes {
    /// Grey levels, colours and pyramid of the picture.
    pub picture_ms: f64,
    /// Flow, with the references.
    pub flow_ms: f64,
    /// Checks of the picture and of the flow, flags.
    pub checks_ms: f64,
    /// Depth, contact and force from elasticity; 0 without it.
    pub elastic_ms: f64,
    /// Density, filter and depth from density; 0 without them.
    pub density_ms: f64,
}

impl StageTimes {
    /// Names and times, in the order of the stages.
    #[must_use]
    pub fn named(&self) -> [(&'static str, f64); 5] {
        let Self { picture_ms, flow_ms, checks_ms, elastic_ms, density_ms } = *self;
        [
            ("picture", picture_ms),
            ("flow", flow_ms),
            ("checks", checks_ms),
            ("elastic", elastic_ms),
            ("density", density_ms),
        ]
    }
}

/// Takes the time of one stage after the other.
pub(crate) struct Stopwatch(Instant);

impl Stopwatch {
    pub(crate) fn start() -> Self {
        Self(Instant::now())
    }

    /// Time since the start or the last call, ms.
    pub(crate) fn lap_ms(&mut self) -> f64 {
        let now = Instant::now();
        let lap = now.duration_since(std::mem::replace(&mut self.0, now));
        1e3 * lap.as_secs_f64()
    }
}

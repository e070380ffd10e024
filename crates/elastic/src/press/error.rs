use crate::{BlockError, Pose};

/// Why a press can not be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PressError {
    /// The block can not be.
    #[error(transparent)]
    Block(#[from] BlockError),
    /// A coefficient of friction that can not be.
    #[error("friction is {coefficient}: a finite coefficient above 0 is allowed")]
    Friction {
        /// The coefficient, dimensionless.
        coefficient: f64,
    },
    /// A pose with a number that is not finite.
    #[error("the indenter's pose is not finite: {pose:?}")]
    Pose {
        /// The pose.
        pose: Pose,
    },
    /// The gel finds no rest, however small the steps.
    #[error("the press did not converge beyond a depth of {reached_mm:.3} mm on its way to {asked_mm:.3} mm")]
    Stalled {
        /// Depth of the last pose that converged, mm.
        reached_mm: f64,
        /// Depth that was asked for, mm.
        asked_mm: f64,
    },
    /// The caller asked for it.
    #[error("the press was interrupted")]
    Stopped,
}

use crate::{BlockError, Pose};

/// Why a press cannot be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PressError {
    /// The block is impossible.
    #[error(transparent)]
    Block(#[from] BlockError),
    /// An impossible coefficient of friction.
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
    /// No equilibrium was found, however small the steps.
    #[error("the press did not converge beyond a depth of {reached_mm:.3} mm on its way to {asked_mm:.3} mm")]
    Stalled {
        /// Depth of the last pose that converged, mm.
        reached_mm: f64,
        /// Requested depth, mm.
        asked_mm: f64,
    },
    /// The caller stopped it.
    #[error("the press was interrupted")]
    Stopped,
}

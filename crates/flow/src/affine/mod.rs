//! Affine patches at full resolution, coupled to their neighbours.

mod bonds;
mod coarse_grids;
pub(crate) mod coupling;
mod expander;
mod fine;
pub(crate) mod grid;
mod history;
mod judge;
pub(crate) mod measurement;
pub(crate) mod moments;
pub(crate) mod nodes;
mod noise;
mod own_variance;
pub(crate) mod patches;
mod places;
pub(crate) mod products;
pub(crate) mod refinement;
mod sampling;
mod symmetric;
pub(crate) mod template;
mod visible;

pub use self::history::FlowHistory;
pub use self::noise::STRONG_GRADIENT;

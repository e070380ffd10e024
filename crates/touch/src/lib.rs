//! The sensor.

mod density;
mod guided_filter;
mod reading;

pub use density::{DensityEstimator, DensityField, DensityMethod, DensityParams, ParameterError};
pub use guided_filter::{GuidedFilter, GuidedFilterParams};
pub use reading::{Flag, Flags, Reading};

//! The sensor.

mod density;
mod depth_line;
mod guided_filter;
mod profile;
mod reading;
mod references;

pub use density::{DensityEstimator, DensityField, DensityMethod, DensityParams, ParameterError};
pub use depth_line::DepthLine;
pub use guided_filter::{GuidedFilter, GuidedFilterParams};
pub use profile::{
    CameraSection, DepthMethod, DepthSection, Distortion, GelSection, ImageSection, Place, Profile, ProfileError,
};
pub use reading::{Flag, Flags, Reading};
pub use references::{Policy, ReferenceParams};

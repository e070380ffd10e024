//! Dense optical flow between two images.

mod field;

pub use field::FlowField;

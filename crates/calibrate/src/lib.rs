//! Calibration: fits that write a sensor's profile, each with a report on what it is worth.

pub mod camera;
pub mod depth;
mod profile_file;

pub use profile_file::{ProfileFileError, update_profile};

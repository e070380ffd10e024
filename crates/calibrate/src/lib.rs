//! Calibration: fits that write a sensor's profile, each with a report on what it is worth, and checks of the recordings
//! that they are made from.

pub mod camera;
pub mod check;
pub mod depth;
pub mod gel;
mod profile_file;

pub use profile_file::{ProfileFileError, load_to_update, update_profile};

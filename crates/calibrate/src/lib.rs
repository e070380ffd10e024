//! Calibration: fits that write a sensor's profile, each with a report of its accuracy, and checks of the recordings they
//! use.

pub mod camera;
pub mod check;
pub mod depth;
pub mod gel;
mod profile_file;

pub use profile_file::{ProfileFileError, load_to_update, update_profile};

//! Calibration: fits that write a sensor's profile, each with a report of its accuracy, and checks of the recordings they
//! use.

pub mod camera;
pub mod check;
mod csv_table;
pub mod depth;
pub mod gel;
mod profile_file;

pub use csv_table::{CsvFault, CsvRow, CsvTable};
pub use profile_file::{ProfileFileError, load_to_update, update_profile, write_profile};

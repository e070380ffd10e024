//! The sensor.

mod reading;

pub use reading::{Flag, Flags, Reading};

//! Calibration: fits that write a sensor's profile, each with a report on what it is worth.

mod camera;
mod depth;

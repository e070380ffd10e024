//! Tests of the crate from outside, in one program: it is linked once, and its tests run side by side.

#![allow(clippy::unwrap_used, reason = "a test may fail where it stands")]

mod camera;
mod disk;
mod format;
mod fuzz;
mod recorder;
mod round_trip;
mod written;

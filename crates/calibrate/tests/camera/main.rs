//! Cameras from sliding boards, held to the cameras that saw them.

#![allow(clippy::unwrap_used, reason = "what helps a test may panic like one")]

mod checkerboard;
mod rendered;
mod synthetic;
mod world;

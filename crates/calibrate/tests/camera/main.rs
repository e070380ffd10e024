//! Cameras fitted to sliding boards, compared with the true cameras.

#![allow(clippy::unwrap_used, reason = "test helpers may panic, like tests")]

mod checkerboard;
mod rendered;
mod synthetic;
mod world;

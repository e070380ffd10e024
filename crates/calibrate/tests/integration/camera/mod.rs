//! Cameras fitted to sliding boards, compared with the true cameras.

mod checkerboard;
mod rendered;
mod synthetic;
mod world;

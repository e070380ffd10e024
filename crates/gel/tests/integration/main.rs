//! Tests of the crate from outside, in one program: it is linked once, and its tests run side by side.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may fail where it stands")]

mod fuzz;
mod lanczos;
mod print;
mod sub_pixel_bias;
mod surface_flow;
mod trackability;

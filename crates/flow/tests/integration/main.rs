//! Tests of the crate from outside, in one program: it is linked once, and its tests run side by side.

#![allow(clippy::unwrap_used, reason = "a test may fail where it stands")]

mod blur;
mod light;
mod noise;
mod recovery;
mod team;
mod validity;

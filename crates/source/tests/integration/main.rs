//! Tests of the crate from outside, in one program: it is linked once, and its tests run side by side.

#![allow(clippy::unwrap_used, reason = "a test may fail where it stands")]

#[cfg(feature = "video")]
mod damage;
mod folder;
mod fuzz;
#[cfg(feature = "video")]
mod video;

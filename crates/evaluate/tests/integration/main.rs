//! Tests of the crate from outside, in one program: it is linked once, and its tests run side by side.

#![allow(clippy::unwrap_used, reason = "a test may fail where it stands")]

mod accuracy;
mod recorded_press;
mod run;
mod trackability;

//! Tests of the crate from outside, in one program: it is linked once, and its tests run side by side.

#![allow(clippy::unwrap_used, reason = "a test may fail where it stands")]

mod coarse_colour;
mod dragged;
mod elastic;
mod elastic_depth;
mod elastic_tracking;
mod focus;
mod fuzz;
mod health;
mod moved_camera;
mod press;
mod properties;
mod rezero;
mod solved;
mod torn;
mod tracker;

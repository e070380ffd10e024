//! Mutated images and videos: frames or an error, within bounds of memory, never a panic.

#![allow(clippy::unwrap_used, reason = "a test may fail where it stands")]

mod images;
mod videos;

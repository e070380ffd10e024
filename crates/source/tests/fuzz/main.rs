//! Mutated images and videos: frames or an error, within bounds of memory, never a panic.

#![allow(clippy::unwrap_used, reason = "a test may fail where it stands")]

mod images;
mod videos;

/// The most memory that one file may take, bytes: a picture of 1 GiB, in a decoder and out of it.
const MOST_BYTES: u64 = 5 << 29;

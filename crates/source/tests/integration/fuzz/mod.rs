//! Mutated camera frames, images and videos: pixels or an error, within bounds of memory, never a panic.

mod cameras;
mod images;
#[cfg(feature = "video")]
mod videos;

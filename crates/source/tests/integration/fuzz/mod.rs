//! Mutated images and videos: frames or an error, within bounds of memory, never a panic.

mod images;
#[cfg(feature = "video")]
mod videos;

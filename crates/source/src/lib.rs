//! Frame sources: every command reads its frames through [`Source`].
//!
//! [`open`] examines the path and selects the reader. Two kinds are read:
//!
//! - A **folder of images**: PNG, JPEG, TIFF and BMP, one frame a file, in natural order (`frame2` before `frame10`).
//!   Grey and colour, 8 and 16 bit, are kept as they are stored; floating-point TIFF must lie in 0 to 1 and becomes 16
//!   bit. A palette reads as colour, transparency is dropped. The time of a frame is nominal: its number over
//!   [`Options::frames_per_second`]. If the names number the images, a missing number leaves a gap in the frames'
//!   sequence numbers.
//! - A **video file**: H.264 in MP4 or MOV, and motion JPEG in AVI, MP4 or MOV. Frames come in the order in which they
//!   are shown, at the presentation time that the file carries; a jump in time leaves a gap in their sequence numbers.
//!   Feature `video`, on by default.
//!
//! Luma and chroma become RGB by the matrix and range that the video names; where it names none, by BT.601 in limited
//! range. Bytes damaged within a compressed H.264 frame may go unnoticed: the format has no checksums.
//!
//! Pictures are rotated upright if the file contains the camera's orientation. A source keeps one frame in memory (a
//! video with B-frames up to seventeen), and ends with an error, not silently, where a file is cut off.
//!
//! [`CameraFrameDecoder`] decodes single frames, as a camera delivers them: an [`EncodedFrame`] is such a frame.
//!
//! Not read: H.265, VP9, AV1, Matroska, `WebM`, 10-bit and 4:4:4 H.264, H.264 in AVI. The error says so, and its
//! [hint](SourceError::hint) gives the command that converts the file.

mod camera_frame;
mod compression;
mod encoded_frame;
mod error;
mod folder;
mod format;
mod guarded;
mod jpeg;
mod motion_jpeg;
mod natural;
mod numbering;
mod open;
mod picture;
mod recordings;
mod regular;
mod repetition;
mod reuse;
mod source;
#[cfg(feature = "video")]
mod video;
mod yuv;

pub use camera_frame::{CameraCoding, CameraFrameDecoder, CameraLayout};
pub use encoded_frame::EncodedFrame;
pub use error::SourceError;
pub use format::FrameFormat;
pub use open::open;
pub use recordings::{images_of, recordings_in};
pub use repetition::{Repetition, repetition};
pub use source::{FrameTruth, Options, Source};

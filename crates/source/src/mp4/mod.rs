//! MP4 and MOV files (ISO/IEC 14496-12): which bytes are the frames of the video, and when each is shown.
//!
//! Written here because a reader must bear any file: every count is checked against the bytes that are there before
//! memory is taken, only the index is held in memory, and a file that is cut off yields its whole frames.
//!
//! Read are plain and fragmented files, B-frames (composition offsets), variable frame times, and an edit list with one
//! edit, before which the film may wait. Several edits, or one that changes the speed, are refused.

mod boxes;
mod codec;
mod edits;
mod fragments;
mod movie;
mod samples;

pub(crate) use movie::read_track;

//! MP4 and MOV files (ISO/IEC 14496-12): which bytes are the frames of the video, and when each is shown.
//!
//! Implemented here because a reader must cope with any file: every count is checked against the available bytes before
//! memory is allocated, only the index is kept in memory, and a file that is cut off yields its complete frames.
//!
//! Plain and fragmented files are read, with B-frames (composition offsets), variable frame times, and an edit list
//! with one edit, which may delay the start of the video. Several edits, or one that changes the speed, are refused.

mod boxes;
mod codec;
mod edits;
mod fragments;
mod movie;
mod samples;

pub(crate) use movie::read_track;

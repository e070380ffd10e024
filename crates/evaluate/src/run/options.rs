//! How a comparison is made.

/// How a run and its truth are brought together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Options {
    /// Compare the first frames, those that all files hold, where files count different numbers of them.
    pub common_frames: bool,
}

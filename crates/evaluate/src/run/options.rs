//! Options of a comparison.

/// Options of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Options {
    /// If the files contain different numbers of frames, compare the first frames, which all files contain.
    pub common_frames: bool,
}

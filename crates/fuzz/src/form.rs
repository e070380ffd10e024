//! The two forms of files: binary and text.

/// The form of a file, which determines how it is mutated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Numbers as bytes.
    Binary,
    /// Lines and words; after some mutations it is not UTF-8.
    Text,
}

//! The two forms that files have.

/// What a file consists of: how it is mutated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Numbers as bytes.
    Binary,
    /// Lines and words; some mutations leave it no UTF-8.
    Text,
}

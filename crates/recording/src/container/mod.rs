//! MCAP, the file format: records one after the other, messages in chunks, an index at the end.
//!
//! <https://mcap.dev/spec> describes it. [`writer`] only appends, so the file can be read however the program ended.
//! [`scan`] reads a file from its start to its end, or to where it is cut off, and needs no index.

mod record;
pub(crate) mod scan;
mod summary;
#[cfg(test)]
mod tests;
pub(crate) mod writer;

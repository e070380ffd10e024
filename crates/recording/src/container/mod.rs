//! MCAP, the file format: records one after the other, messages in chunks, an index at the end.
//!
//! <https://mcap.dev/spec> describes it. [`writer`] only appends, so whatever ends the program leaves a file that can be
//! read; [`scan`] reads a file from its start to its first fault and needs no index.

mod record;
pub(crate) mod scan;
mod summary;
#[cfg(test)]
mod tests;
pub(crate) mod writer;

//! A guard around decoders of other libraries.

use std::panic::{AssertUnwindSafe, catch_unwind};

/// Runs foreign decoding code; a panic in there becomes an error.
///
/// The H.264 decoder is new and gets files from anywhere. Some damaged files make it panic, and a panic must not
/// end a robot's process. After a panic the decoder is in an unknown state and must not be used again: a source that
/// continues after an error does so with a new decoder.
pub(crate) fn guarded<T>(decode: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(decode)).map_err(|_| "damaged so much that the decoder fails".into())
}

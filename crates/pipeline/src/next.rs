//! What an input gives next.

use crate::PipelineError;

/// The next item of an input.
pub(crate) enum Next {
    /// A frame was written. It was captured at this time.
    Frame { captured_s: f64 },
    /// An event, as a sentence.
    Event(String),
    /// A frame that cannot be read is left out, as a sentence.
    Damaged(String),
    /// No frame yet.
    Nothing,
    /// The end, with the error if it came early.
    End(Option<PipelineError>),
}

//! A frame between capture and tracking.

use std::sync::Arc;

use fingervision_source::{EncodedFrame, FrameTruth};

/// A frame on its way to the tracker.
#[derive(Debug, Clone)]
#[expect(clippy::struct_field_names, reason = "the time has this name in messages and files")]
pub(crate) struct Captured {
    pub(crate) frame: Arc<EncodedFrame>,
    pub(crate) captured_s: f64,
    /// What is known of it, if it is simulated.
    pub(crate) truth: Option<FrameTruth>,
}

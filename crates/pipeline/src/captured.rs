//! A frame between capture and tracking.

use std::sync::Arc;

use fingervision_source::EncodedFrame;

/// A frame on its way to the tracker.
#[derive(Clone)]
pub(crate) struct Captured {
    pub(crate) frame: Arc<EncodedFrame>,
    pub(crate) captured_s: f64,
}

//! The state that the server and the feed share.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use axum::body::Bytes;
use axum::extract::ws::Utf8Bytes;
use fingervision_pipeline::SensorHandle;
use tokio::sync::broadcast;

use crate::Actions;
use crate::access::Access;
use crate::hello::Hello;

/// Messages that may wait for a slow browser: texts, then fields. Beyond that the oldest are dropped.
const TEXTS: usize = 64;
const FIELDS: usize = 8;

/// The state that the server and the feed share.
pub(crate) struct Shared {
    pub(crate) access: Access,
    pub(crate) hello: Hello,
    pub(crate) handles: Vec<SensorHandle>,
    pub(crate) actions: Arc<dyn Actions>,
    pub(crate) texts: broadcast::Sender<Utf8Bytes>,
    pub(crate) fields: broadcast::Sender<Bytes>,
    pages: AtomicUsize,
}

/// One open page, from its connection to its end.
pub(crate) struct OpenPage(Arc<Shared>);

impl Shared {
    pub(crate) fn new(access: Access, handles: &[SensorHandle], actions: Arc<dyn Actions>) -> Self {
        Self {
            access,
            hello: Hello::new(handles),
            handles: handles.to_vec(),
            actions,
            texts: broadcast::Sender::new(TEXTS),
            fields: broadcast::Sender::new(FIELDS),
            pages: AtomicUsize::new(0),
        }
    }

    pub(crate) fn has_pages(&self) -> bool {
        self.pages.load(Ordering::Acquire) > 0
    }

    pub(crate) fn send_text(&self, text: Utf8Bytes) {
        // Without an open page there are no receivers.
        let _ = self.texts.send(text);
    }

    pub(crate) fn send_fields(&self, fields: Bytes) {
        // Without an open page there are no receivers.
        let _ = self.fields.send(fields);
    }
}

impl OpenPage {
    pub(crate) fn new(shared: Arc<Shared>) -> Self {
        shared.pages.fetch_add(1, Ordering::AcqRel);
        Self(shared)
    }
}

impl Drop for OpenPage {
    fn drop(&mut self) {
        self.0.pages.fetch_sub(1, Ordering::AcqRel);
    }
}

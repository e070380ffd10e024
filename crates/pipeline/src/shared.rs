//! The state that a sensor's threads and its handles share.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use fingervision_camera::Counts;

use crate::captured::Captured;

/// Counts of a sensor's frames so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct SensorCounts {
    /// Frames that arrived.
    pub captured: u64,
    /// Frames that were tracked.
    pub tracked: u64,
    /// Frames that were dropped for newer ones, because tracking was busy.
    pub dropped: u64,
    /// Frames that could not be decoded or tracked.
    pub damaged: u64,
    /// The camera's own counts; all zero for other sources.
    pub camera: Counts,
}

/// The state that threads and handles share.
#[derive(Debug, Default)]
pub(crate) struct Shared {
    counts: Mutex<SensorCounts>,
    reference: Mutex<Option<Captured>>,
    is_rezero_asked: AtomicBool,
    is_ended: AtomicBool,
}

impl Shared {
    pub(crate) fn counts(&self) -> SensorCounts {
        *self.counts.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn count(&self, change: impl FnOnce(&mut SensorCounts)) {
        change(&mut self.counts.lock().unwrap_or_else(PoisonError::into_inner));
    }

    pub(crate) fn reference(&self) -> Option<Captured> {
        self.reference.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub(crate) fn set_reference(&self, captured: &Captured) {
        *self.reference.lock().unwrap_or_else(PoisonError::into_inner) = Some(captured.clone());
    }

    pub(crate) fn ask_rezero(&self) {
        self.is_rezero_asked.store(true, Ordering::Release);
    }

    pub(crate) fn take_rezero(&self) -> bool {
        self.is_rezero_asked.swap(false, Ordering::AcqRel)
    }

    pub(crate) fn end(&self) {
        self.is_ended.store(true, Ordering::Release);
    }

    pub(crate) fn is_ended(&self) -> bool {
        self.is_ended.load(Ordering::Acquire)
    }
}

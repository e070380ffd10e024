//! The capturing thread of a sensor.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use fingervision_source::EncodedFrame;

use crate::captured::Captured;
use crate::hub::Hub;
use crate::next::Next;
use crate::pool::Pool;
use crate::queue::Queue;
use crate::ready::Ready;
use crate::sensor::SensorHandle;
use crate::{Input, Message, host_time_s};

/// Frames that subscribers may hold. At 90 frames/s a recorder may be two seconds late.
const MOST_FRAMES: usize = 192;

/// Captures until the source ends or the sensor is stopped.
pub(crate) struct Capture {
    pub(crate) index: usize,
    pub(crate) input: Input,
    pub(crate) handle: SensorHandle,
    /// The first frame, which the tracker already has.
    pub(crate) first: Captured,
    pub(crate) hub: Arc<Hub>,
    pub(crate) queue: Arc<Queue<Captured>>,
    pub(crate) ready: Arc<Ready>,
    pub(crate) is_stopped: Arc<AtomicBool>,
}

impl Capture {
    pub(crate) fn run(mut self) {
        let mut pool = Pool::new(MOST_FRAMES);
        self.count(1);
        self.publish(&self.first);
        while !self.is_stopped.load(Ordering::Acquire) && self.step(&mut pool) {}
        self.queue.close();
        self.ready.announce(self.index);
    }

    /// Takes one frame or event; false at the end.
    fn step(&mut self, pool: &mut Pool<EncodedFrame>) -> bool {
        let wait = self.input.patience();
        let Some(slot) = pool.free(EncodedFrame::empty) else {
            // Subscribers hold all frames of the pool: the next frame is dropped.
            self.handle.shared.count(|counts| counts.dropped += 1);
            let mut unused = EncodedFrame::empty();
            return !matches!(self.input.next(wait, &mut unused), Next::End(_));
        };
        let Some(frame) = Arc::get_mut(slot) else { return true };
        match self.input.next(wait, frame) {
            Next::Frame { captured_s } => {
                let frame = Arc::clone(slot);
                let truth = self.input.truth();
                self.hand_on(Captured { frame, captured_s, truth });
            }
            Next::Event(text) => self.event(text),
            Next::Damaged(text) => {
                self.handle.shared.count(|counts| counts.damaged += 1);
                self.event(text);
            }
            Next::Nothing => {}
            Next::End(reason) => {
                if let Some(reason) = reason {
                    self.event(format!("capture has ended: {reason}"));
                }
                return false;
            }
        }
        true
    }

    /// Counts a frame before anyone sees it, then hands it on.
    fn hand_on(&self, captured: Captured) {
        self.count(1);
        self.publish(&captured);
        if self.handle.is_tracked() && self.queue.push(captured).is_some() {
            self.handle.shared.count(|counts| counts.dropped += 1);
        }
        self.ready.announce(self.index);
    }

    fn publish(&self, captured: &Captured) {
        let (sensor, Captured { frame, captured_s, truth }) = (self.index, captured.clone());
        let (sequence, capture_time_s) = (frame.sequence, frame.capture_time_s);
        self.hub.publish(&Message::Frame { sensor, frame, captured_s });
        if let Some(truth) = truth {
            self.hub.publish(&Message::Truth { sensor, sequence, capture_time_s, captured_s, truth });
        }
    }

    /// Adds to the count of frames and takes over what the camera has counted.
    fn count(&self, frames: u64) {
        let camera = self.input.camera_counts();
        self.handle.shared.count(|counts| {
            counts.captured += frames;
            counts.camera = camera.unwrap_or_default();
        });
    }

    /// Publishes a sentence after what it is about was counted.
    fn event(&self, text: String) {
        self.count(0);
        self.hub.publish(&Message::Event { sensor: self.index, host_time_s: host_time_s(), text });
    }
}

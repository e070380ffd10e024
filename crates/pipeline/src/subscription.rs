//! The receiving end of a subscription.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use crate::queue::{OnFull, Queue};
use crate::{Interest, Message};

/// No fields are wanted.
const NEVER: u64 = u64::MAX;

/// The state that a subscriber and the sensors share.
#[derive(Debug)]
pub(crate) struct Subscriber {
    pub(crate) queue: Queue<Message>,
    pub(crate) wants_frames: bool,
    /// Time between two snapshots of a sensor, ns.
    fields_every_ns: AtomicU64,
    /// Bits of the time at which the next snapshot of each sensor is due, s.
    due_s: Vec<AtomicU64>,
    /// Whether a snapshot of each sensor is due and was not sent yet.
    is_due: Vec<AtomicBool>,
}

impl Subscriber {
    pub(crate) fn new(interest: Interest, on_full: OnFull, sensors: usize) -> Self {
        let subscriber = Self {
            queue: Queue::new(interest.capacity, on_full),
            wants_frames: interest.frames,
            fields_every_ns: AtomicU64::new(NEVER),
            due_s: (0..sensors).map(|_| AtomicU64::new(0)).collect(),
            is_due: (0..sensors).map(|_| AtomicBool::new(false)).collect(),
        };
        subscriber.set_fields_every(interest.fields_every);
        subscriber
    }

    fn set_fields_every(&self, every: Option<Duration>) {
        let every = every.map_or(NEVER, |every| u64::try_from(every.as_nanos()).unwrap_or(NEVER));
        self.fields_every_ns.store(every, Ordering::Relaxed);
    }

    /// Whether a snapshot of a sensor is due; it stays so until [`Self::take_due`].
    pub(crate) fn is_due(&self, sensor: usize, now_s: f64) -> bool {
        let every_ns = self.fields_every_ns.load(Ordering::Relaxed);
        let due_s = f64::from_bits(self.due_s[sensor].load(Ordering::Relaxed));
        if every_ns == NEVER {
            return false;
        }
        if now_s >= due_s {
            let every_s = 1e-9 * every_ns as f64;
            // The requested rate holds on average, although frames do not arrive at the due times.
            let next_s = if now_s - due_s < every_s { due_s + every_s } else { now_s + every_s };
            self.due_s[sensor].store(next_s.to_bits(), Ordering::Relaxed);
            self.is_due[sensor].store(true, Ordering::Relaxed);
        }
        self.is_due[sensor].load(Ordering::Relaxed)
    }

    /// Whether a snapshot was due; it counts as sent afterwards.
    pub(crate) fn take_due(&self, sensor: usize) -> bool {
        self.is_due[sensor].swap(false, Ordering::Relaxed)
    }
}

/// Receives the messages of the sensors, in order.
#[derive(Debug)]
pub struct Subscription {
    subscriber: Arc<Subscriber>,
}

impl Subscription {
    pub(crate) fn new(subscriber: Arc<Subscriber>) -> Self {
        Self { subscriber }
    }

    /// The next message; `None` if none comes within `wait`, or all sensors have ended.
    #[must_use]
    pub fn next(&self, wait: Duration) -> Option<Message> {
        self.subscriber.queue.pop(wait)
    }

    /// Whether all sensors have ended and every message was read.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.subscriber.queue.is_done()
    }

    /// Messages that were lost because this subscriber was too slow.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.subscriber.queue.lost()
    }

    /// Changes the rate of whole readings; see [`Interest::fields_every`].
    pub fn set_fields_every(&self, every: Option<Duration>) {
        self.subscriber.set_fields_every(every);
    }
}

impl Drop for Subscription {
    fn drop(&mut self) {
        self.subscriber.queue.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn snapshots_keep_their_rate_on_average() {
        let every = Some(Duration::from_millis(30));
        let subscriber =
            Subscriber::new(Interest { frames: false, fields_every: every, capacity: 4 }, OnFull::DropOldest, 1);
        let is_sent = |frame: &i32| subscriber.is_due(0, 100.0 + f64::from(*frame) / 90.0) && subscriber.take_due(0);
        let count = (0..1000).filter(is_sent).count();
        assert!((360..=371).contains(&count), "{count} in 11.1 s");
        subscriber.set_fields_every(None);
        assert!(!subscriber.is_due(0, 1e6));
    }
}

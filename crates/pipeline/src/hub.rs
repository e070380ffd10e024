//! Sends messages to all subscribers.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::queue::OnFull;
use crate::subscription::Subscriber;
use crate::{Interest, Message, Subscription};

/// The subscribers of a pipeline.
#[derive(Debug)]
pub(crate) struct Hub {
    state: Mutex<State>,
    sensors: usize,
}

#[derive(Debug)]
struct State {
    subscribers: Vec<Arc<Subscriber>>,
    /// Sensors that have not ended.
    running: usize,
}

impl Hub {
    pub(crate) fn new(sensors: usize) -> Self {
        Self { state: Mutex::new(State { subscribers: Vec::new(), running: sensors }), sensors }
    }

    pub(crate) fn subscribe(&self, interest: Interest, on_full: OnFull) -> Subscription {
        let subscriber = Arc::new(Subscriber::new(interest, on_full, self.sensors));
        let mut state = self.lock();
        if state.running == 0 {
            subscriber.queue.close();
        }
        state.subscribers.push(Arc::clone(&subscriber));
        Subscription::new(subscriber)
    }

    /// Sends a message to all subscribers that requested it, and removes those whose subscription was dropped.
    pub(crate) fn publish(&self, message: &Message) {
        let mut state = self.lock();
        state.subscribers.retain(|subscriber| Arc::strong_count(subscriber) > 1);
        for subscriber in &state.subscribers {
            if subscriber.wants_frames || !matches!(message, Message::Frame { .. } | Message::Truth { .. }) {
                drop(subscriber.queue.push(message.clone()));
            }
        }
        if matches!(message, Message::End { .. }) {
            state.running = state.running.saturating_sub(1);
            if state.running == 0 {
                state.subscribers.iter().for_each(|subscriber| subscriber.queue.close());
            }
        }
    }

    /// Sends a snapshot of a sensor's reading if one is due for a subscriber. `take` makes the snapshot, or returns
    /// `None` if it cannot.
    pub(crate) fn publish_fields(&self, sensor: usize, now_s: f64, take: impl FnOnce() -> Option<Message>) {
        // Not `any`: `is_due` updates the time of each subscriber.
        let due = self.lock().subscribers.iter().filter(|subscriber| subscriber.is_due(sensor, now_s)).count();
        if due == 0 {
            return;
        }
        // The copy is made while the lock is free, because other sensors need it.
        let Some(message) = take() else { return };
        for subscriber in self.lock().subscribers.iter().filter(|subscriber| subscriber.take_due(sensor)) {
            drop(subscriber.queue.push(message.clone()));
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

//! Makes subscriptions while sensors run.

use std::sync::Arc;

use crate::hub::Hub;
use crate::queue::OnFull;
use crate::{Interest, Message, Subscription, host_time_s};

/// Makes subscriptions, and publishes events of other parts of the program. Clones belong to the same sensors.
#[derive(Debug, Clone)]
pub struct Subscriptions {
    hub: Arc<Hub>,
}

impl Subscriptions {
    pub(crate) fn new(hub: Arc<Hub>) -> Self {
        Self { hub }
    }

    /// A new subscriber; it gets the messages that follow.
    #[must_use]
    pub fn subscribe(&self, interest: Interest) -> Subscription {
        self.hub.subscribe(interest, OnFull::DropOldest)
    }

    /// Sends a sentence to all subscribers, as an event of this sensor.
    pub fn announce(&self, sensor: usize, text: impl Into<String>) {
        self.hub.publish(&Message::Event { sensor, host_time_s: host_time_s(), text: text.into() });
    }
}

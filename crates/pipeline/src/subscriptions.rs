//! Where new subscribers come from while sensors run.

use std::sync::Arc;

use crate::hub::Hub;
use crate::queue::OnFull;
use crate::{Interest, Message, Subscription, host_time_s};

/// Makes subscriptions, and tells subscribers what others do. Clones belong to the same sensors.
#[derive(Debug, Clone)]
pub struct Subscriptions {
    hub: Arc<Hub>,
}

impl Subscriptions {
    pub(crate) fn new(hub: Arc<Hub>) -> Self {
        Self { hub }
    }

    /// A new subscriber, from now on.
    #[must_use]
    pub fn subscribe(&self, interest: Interest) -> Subscription {
        self.hub.subscribe(interest, OnFull::DropOldest)
    }

    /// Hands a sentence to all subscribers, as an event of this sensor.
    pub fn announce(&self, sensor: usize, text: impl Into<String>) {
        self.hub.publish(&Message::Event { sensor, host_time_s: host_time_s(), text: text.into() });
    }
}

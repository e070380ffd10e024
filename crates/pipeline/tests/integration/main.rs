//! Sensors that run: frames of a moving pattern, and a camera that fails on demand.

#![allow(clippy::unwrap_used, reason = "a test may fail where it stands")]

mod camera;
mod film;
mod rezero;
mod subscribers;
mod tracking;

use fingervision_pipeline::{Message, Subscription};
use std::time::Duration;

/// Longer than anything here takes.
const LONG: Duration = Duration::from_mins(1);

/// Everything that comes until all sensors have ended.
fn until_the_end(subscription: &Subscription) -> Vec<Message> {
    std::iter::from_fn(|| subscription.next(LONG)).collect()
}

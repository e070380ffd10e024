//! Results of the checks for rendered recordings, without faults and with a single fault.

#![allow(clippy::unwrap_used, reason = "test helpers may panic, like tests")]

mod board;
mod press;
mod rendered;
mod still;

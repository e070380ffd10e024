//! What the checks say of rendered recordings, sound ones and ones with a single fault.

#![allow(clippy::unwrap_used, reason = "what helps a test may panic like one")]

mod board;
mod press;
mod rendered;
mod still;

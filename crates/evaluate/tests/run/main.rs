//! A run against its truth: numbers added up by hand, and folders that are not well.

#![allow(clippy::unwrap_used, reason = "what helps a test may panic like one")]

mod faults;
mod fuzz;
mod made_up;
mod numbers;
mod reading;

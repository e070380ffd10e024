//! Comparison of a run with its truth: numbers computed by hand, and faulty folders.

#![allow(clippy::unwrap_used, reason = "test helpers may panic, like tests")]

mod faults;
mod fuzz;
mod made_up;
mod numbers;
mod reading;

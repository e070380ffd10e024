//! Comparison of a run with its truth: numbers computed by hand, and faulty folders.

mod faults;
mod fuzz;
mod made_up;
mod numbers;
mod reading;

//! Results of the checks for rendered recordings, without faults and with a single fault.

mod board;
mod press;
mod rendered;
mod still;

//! The page as a browser sees it: its files, its messages, and who may have them.

#![allow(clippy::unwrap_used, reason = "a test may fail where it stands")]

mod bench;
mod requests;
mod socket;

//! The page as a browser sees it: its files, its messages, and who may have them.

#![allow(clippy::unwrap_used, reason = "a test may fail where it stands")]
#![allow(clippy::print_stdout, reason = "a skipped test says so")]

mod bench;
mod browser;
mod chromium;
mod requests;
mod socket;

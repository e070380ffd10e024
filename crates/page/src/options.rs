//! Where the page is served, and what it may do.

use std::net::{IpAddr, Ipv4Addr};
use std::path::PathBuf;

/// Where the page is served.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PageOptions {
    /// The address to serve at. Other than a loopback address, it can be reached from other machines, with a token.
    pub address: IpAddr,
    /// The port; absent: 8090 or the next free one.
    pub port: Option<u16>,
}

impl Default for PageOptions {
    /// For this machine alone.
    fn default() -> Self {
        Self { address: IpAddr::V4(Ipv4Addr::LOCALHOST), port: None }
    }
}

/// What the page asks the program for, besides readings.
pub trait Actions: Send + Sync {
    /// Begins a recording of all sensors, or ends it. Returns the file that is being written, if any.
    ///
    /// # Errors
    ///
    /// A sentence for the user if recording cannot begin.
    fn set_recording(&self, on: bool) -> Result<Option<PathBuf>, String>;

    /// The file that is being written, its bytes and its seconds so far; absent if nothing is recorded.
    fn recording(&self) -> Option<(PathBuf, u64, f64)>;
}

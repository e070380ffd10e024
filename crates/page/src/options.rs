//! Options of the page: its address, and the actions that it offers.

use std::net::{IpAddr, Ipv4Addr};
use std::path::PathBuf;

/// Where the page is served.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PageOptions {
    /// The address to serve at. If it is not a loopback address, other machines can open the page, with a token.
    pub address: IpAddr,
    /// The port; absent: 8090 or the next free one.
    pub port: Option<u16>,
}

impl Default for PageOptions {
    /// The loopback address: only this machine can open the page.
    fn default() -> Self {
        Self { address: IpAddr::V4(Ipv4Addr::LOCALHOST), port: None }
    }
}

/// Actions of the program that the page can request.
pub trait Actions: Send + Sync {
    /// Begins a recording of all sensors, or ends it. Returns the file that is then being written, if any.
    ///
    /// # Errors
    ///
    /// A sentence for the user if recording cannot begin.
    fn set_recording(&self, on: bool) -> Result<Option<PathBuf>, String>;

    /// The file that is being written, its bytes and its seconds so far; absent if nothing is recorded.
    fn recording(&self) -> Option<(PathBuf, u64, f64)>;
}

//! The sensors in Foxglove, if the program was built with this feature.

use fingervision_pipeline::Running;

use crate::failure::Failure;

/// What a program without the feature answers.
const ABSENT: &str =
    "this program was built without Foxglove; `cargo install --path crates/cli --features foxglove` builds it in";

#[cfg(feature = "foxglove")]
pub(super) use fingervision_foxglove::FoxgloveServer;

/// A server that no program without the feature has.
#[cfg(not(feature = "foxglove"))]
#[derive(Debug)]
pub(super) enum FoxgloveServer {}

#[cfg(not(feature = "foxglove"))]
impl FoxgloveServer {
    pub(super) fn url(&self) -> String {
        match *self {}
    }
}

/// Parses a port. Without the feature every one is refused.
pub(super) fn port(text: &str) -> Result<u16, String> {
    if cfg!(not(feature = "foxglove")) {
        return Err(ABSENT.into());
    }
    text.parse().map_err(|_| "a port is a whole number from 0 to 65535".into())
}

/// Refuses a port that could not be served now.
#[cfg(feature = "foxglove")]
pub(super) fn check(port: u16) -> Result<(), Failure> {
    FoxgloveServer::check(port).map_err(|error| failure(&error))
}

#[cfg(not(feature = "foxglove"))]
pub(super) fn check(_port: u16) -> Result<(), Failure> {
    Err(absent())
}

/// Serves the sensors at a port of this machine until the server is dropped.
#[cfg(feature = "foxglove")]
pub(super) fn start(port: u16, running: &Running) -> Result<FoxgloveServer, Failure> {
    let messages = running.subscribe(FoxgloveServer::interest());
    FoxgloveServer::start(port, running.handles(), messages).map_err(|error| failure(&error))
}

#[cfg(not(feature = "foxglove"))]
pub(super) fn start(_port: u16, _running: &Running) -> Result<FoxgloveServer, Failure> {
    Err(absent())
}

#[cfg(feature = "foxglove")]
fn failure(error: &fingervision_foxglove::FoxgloveServerError) -> Failure {
    Failure::new(error.to_string(), error.hint())
}

#[cfg(not(feature = "foxglove"))]
fn absent() -> Failure {
    Failure::new(ABSENT, "leave out --foxglove")
}

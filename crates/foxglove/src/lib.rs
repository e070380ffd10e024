//! Live sensors in Foxglove, a program that shows data of robots.
//!
//! With the feature `server`, `FoxgloveServer::start` serves a WebSocket that Foxglove opens as a data source. Topics,
//! messages and schemas are those of a recording, without the stored frames, so the same layout shows both. A topic
//! that no client shows is not encoded.
//!
//! The server is a subscriber of a pipeline ([`fingervision_pipeline`]): a client that is too slow loses messages, and tracking
//! does not wait for it.

#[cfg(feature = "server")]
mod error;
#[cfg(feature = "server")]
mod server;

#[cfg(feature = "server")]
pub use error::FoxgloveServerError;
#[cfg(feature = "server")]
pub use server::FoxgloveServer;

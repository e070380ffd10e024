//! Live sensors in Foxglove, a program that shows data of robots.
//!
//! [`FoxgloveServer::start`] serves a WebSocket that Foxglove opens as a data source. Topics, messages and schemas are those of
//! a recording, without the stored frames, so the same layout shows both. A topic that no client shows is not encoded.
//!
//! The server is a subscriber of a pipeline ([`fingervision_pipeline`]): a client that is too slow loses messages, and tracking
//! does not wait for it.

mod error;
mod server;

pub use error::FoxgloveServerError;
pub use server::FoxgloveServer;

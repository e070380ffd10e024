//! Sensors live in Foxglove, the program that shows data of robots.
//!
//! [`FoxgloveServer::start`] serves the WebSocket that Foxglove opens as a data source. Topics, messages and schemas are those
//! of a recording, so the same layout shows both; the stored frames are left out. A topic that nobody shows costs nothing.
//!
//! The server takes readings as any other subscriber of a pipeline ([`fingervision_pipeline`]): a client that is too slow loses
//! messages, and tracking never waits for it.

mod error;
mod server;

pub use error::FoxgloveServerError;
pub use server::FoxgloveServer;

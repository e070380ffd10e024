//! A web page that shows live sensors, served by the program itself.
//!
//! [`Page::start`] serves the page on a thread of its own: camera image with the outline of contact, depth, a surface
//! that can be turned, arrows of shear and traction, forces over time, and the state of every sensor. All files of the
//! page are part of the program; nothing is loaded from other servers.
//!
//! The page is a subscriber of a pipeline ([`fingervision_pipeline`]). Fields are copied and pictures are encoded only
//! while a page is open, and a browser that is too slow gets fewer of them. Tracking never waits for the page.
//!
//! **Access.** By default only this machine can open the page. If the page is bound to another address, requests need
//! the token that is part of [`Page::url`]. Requests that another web site makes (`Origin`) or that name another host
//! (`Host`) are refused.
//!
//! The format of the messages is described in `wire.rs` and in `docs/live.md`.

mod access;
mod arrows;
mod assets;
mod error;
mod feed;
mod hello;
mod options;
mod page;
mod picture;
mod server;
mod shared;
mod wire;

pub use error::PageError;
pub use options::{Actions, PageOptions};
pub use page::Page;

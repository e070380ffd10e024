//! A web page that shows sensors live, served by the program itself.
//!
//! [`Page::start`] serves the page on a thread of its own: camera image with the outline of contact, depth, a surface that
//! can be turned, arrows of shear and traction, forces over time, and the state of every sensor. Everything that the page
//! needs is part of the program; nothing is loaded from elsewhere.
//!
//! The page takes readings as any other subscriber of a pipeline ([`fingervision_pipeline`]): fields are copied and pictures
//! made only while a page is open, and a browser that is too slow gets fewer of them. Tracking never waits for it.
//!
//! **Access.** Without a wish the page can be reached from this machine alone. Bound to another address it needs the token
//! that is part of [`Page::url`]. Requests that another web site makes (`Origin`) or that name another host (`Host`) are
//! refused.
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

//! Readings out: arrays, a table and pictures.
//!
//! A [`Sink`] is handed every reading of a run. [`RunFolder`] streams them into files that can be read at any moment;
//! [`heat_map`], stand on their own.

mod arrays;
mod error;
mod run_folder;
mod sink;
mod table;

pub use arrays::{ArrayWriter, Element};
pub use error::SinkError;
pub use run_folder::{Field, RunFolder, RunOptions, RunSummary};
pub use sink::Sink;
pub use table::{COLUMNS, Table};

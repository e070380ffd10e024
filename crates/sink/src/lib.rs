//! Output of readings: arrays, a table and pictures.
//!
//! A [`Sink`] receives every reading of a run. [`RunFolder`] streams them into files that can be read at any moment;
//! [`Preview`] keeps the strongest frame and draws it as one picture, [`Overlay`] makes a video of all. The parts of these
//! pictures are in `fingervision-plot`; `fingervision-simulation` writes a simulated press with its truth.

mod arrays;
mod avi;
mod claim;
mod error;
mod export;
mod field;
mod float_array;
#[cfg(feature = "mp4")]
mod mp4;
mod picture;
mod rows;
mod run_fields;
mod run_folder;
mod run_options;
mod sink;
mod table;
mod video;
mod whole_file;

pub use arrays::{ArrayWriter, Element};
pub use claim::{FolderKind, FolderLock};
pub use error::SinkError;
pub use export::{Column, RunArray, RunArrays, RunTable, write_npz, write_zarr};
pub use field::Field;
pub use picture::{Overlay, Preview, PreviewOptions, png, write_pixels, write_png};
pub use rows::Rows;
pub use run_folder::{RunFolder, RunSummary};
pub use run_options::{Precision, RunOptions};
pub use sink::Sink;
pub use table::{COLUMNS, Table};
pub use whole_file::write_file;

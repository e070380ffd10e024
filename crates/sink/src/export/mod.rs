//! A run folder in other forms: one file for `NumPy`, a Zarr group.

mod npz;
mod run_arrays;
mod run_table;
mod zarr;

pub use npz::write_npz;
pub use run_arrays::{RunArray, RunArrays};
pub use run_table::{Column, RunTable};
pub use zarr::write_zarr;

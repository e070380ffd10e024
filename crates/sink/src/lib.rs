//! Readings out: arrays, a table and pictures.
//!
//! A [`Sink`] receives every reading of a run. [`RunFolder`] streams them into files that can be read at any moment;
//! [`Preview`] keeps the strongest frame and draws it as one picture, [`Overlay`] makes a video of all. [`Comparison`]
//! shows estimated fields beside true ones. `SimulationFolder` (feature `simulate`) takes a simulated press with its
//! truth. The parts of these pictures, [`flow_colours`] and [`heat_map`], can be used separately.

mod arrays;
mod avi;
mod claim;
mod error;
mod float_array;
mod picture;
mod rows;
mod run_fields;
mod run_folder;
#[cfg(feature = "simulate")]
mod simulation_folder;
mod sink;
mod table;

pub use arrays::{ArrayWriter, Element};
pub use claim::{FolderKind, FolderLock};
pub use error::SinkError;
pub use float_array::Precision;
#[cfg(feature = "simulate")]
pub use picture::SimulationPreview;
pub use picture::{
    ColourMap, Comparison, Curve, CurvePanel, CurvePlots, FramePlot, HeatPanel, HeatPanels, HeatScale, INVALID_COLOUR,
    Overlay, Pair, Preview, PreviewOptions, StraightLine, colour_wheel, flow_colours, heat_map, png, write_pixels,
    write_png,
};
pub use run_fields::Field;
pub use run_folder::{RunFolder, RunOptions, RunSummary};
#[cfg(feature = "simulate")]
pub use simulation_folder::{SimulatedFrame, SimulationFolder, simulated_profile};
pub use sink::Sink;
pub use table::{COLUMNS, Table};

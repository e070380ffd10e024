//! Compares a run with its truth, as `fingervision evaluate` does.
//!
//! A *run* is a folder that the tracker wrote, or any other program in its layout; a *truth* is one that the simulator
//! wrote. Both contain arrays `[frame][row][column]`, which are read side by side, one frame at a time. Per frame, only
//! the numbers of the report are kept in memory.
//!
//! # Compared pixels
//!
//! A pixel is compared if the truth is visible (`visible.npy`, and the truth is a number) and the estimate is valid
//! (`valid.npy`; if that is absent, if the estimate is a number). Fields that only one side has are not compared, and
//! the report names them. If only a part of the image was tracked, the run's `run.toml` gives that part, and the truth
//! is cropped.
//!
//! Depth from elasticity is also valid where the flow is not. Such a run contains a `depth_valid.npy`: depth,
//! displacement and contact are then compared where this mask is 1, whether or not the flow is valid. Depth is compared
//! a second time over the pixels where both masks are 1.
//!
//! The pixels that are not compared are counted by region ([`PixelCounts`]): errors near the border of contact mean
//! little if the run marks few pixels there as valid.
//!
//! # Regions
//!
//! | region | which pixels |
//! | --- | --- |
//! | everywhere | all that are compared |
//! | inside contact | in the truth's contact |
//! | near its border | at most [`BORDER_MM`] from the border of the truth's contact, on **both** sides |
//! | outside | neither in contact nor near its border |
//!
//! The first two overlap with the third: the inner half of the band near the border is in contact as well. Distances
//! are measured on the undeformed gel, with the camera of the truth's `profile.toml`.
//!
//! # Errors
//!
//! The error of depth is `|estimate − truth|`, mm; the error of the flow is the length of the difference between
//! estimated and true flow, px. [`Errors`] contains their mean, root mean square, 95th percentile and maximum, and
//! bias, peaks and correlation. They are given for each frame, as the mean over the frames, and over all pixels of all
//! frames together.
//!
//! ```no_run
//! use fingervision_evaluate::run::{Evaluation, Options};
//!
//! let mut evaluation = Evaluation::open("run".as_ref(), "simulation".as_ref(), Options::default())?;
//! while evaluation.advance()? {}
//! let outcome = evaluation.finish();
//! println!("{}", outcome.report);
//! # Ok::<(), fingervision_evaluate::run::RunError>(())
//! ```

mod array;
mod border;
mod compare;
mod correlation;
mod error;
mod evaluation;
mod fields;
mod force;
mod grid;
mod histogram;
mod inputs;
mod judgement;
mod last_frame;
mod npy_header;
mod numbers;
mod options;
mod origin;
mod picture;
mod report;
mod table_file;
mod tally;
mod text;

pub(crate) use border::BorderBand;
pub(crate) use correlation::Correlation;
pub use error::RunError;
pub use evaluation::{Evaluation, Outcome};
pub(crate) use force::{LEAST_ARM_MM, LEAST_SHEAR};
pub(crate) use last_frame::LastFrame;
pub(crate) use npy_header::NpyHeader;
pub use options::Options;
pub use report::{
    Components, Errors, FieldErrors, ForceErrors, ForceReport, FrameReport, LoadErrors, PixelCounts, Region, Regions,
    Report,
};

/// Width of the region near the border of contact on either side, mm on the undeformed gel.
pub const BORDER_MM: f64 = 1.0;

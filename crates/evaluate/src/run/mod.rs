//! A run against its truth: what `fingervision evaluate` measures.
//!
//! A *run* is a folder that the tracker wrote, or any other program in its layout; a *truth* is one that the simulator
//! wrote. Both hold arrays `[frame][row][column]`, which are read side by side, a frame at a time: memory grows with
//! the number of frames by the report's figures only.
//!
//! # What is compared
//!
//! A pixel is compared where the truth is seen (`visible.npy`, and the truth is a number) and the estimate holds
//! (`valid.npy`; where that is absent, wherever the estimate is a number). Fields that only one side has are left out,
//! and the report says so. A run on a part of the image names it in its `run.toml`, and the truth is cropped.
//!
//! Depth from elasticity is also valid where the flow is not. Such a run contains a `depth_valid.npy`: depth, displacement and
//! contact are then compared where that holds, whatever `valid.npy` says of the flow, and depth once more over the pixels
//! where both hold.
//!
//! What is not compared is counted by region ([`PixelCounts`]): the errors near the contact's border mean little where
//! a run trusts few of its pixels.
//!
//! # Regions
//!
//! | region | which pixels |
//! | --- | --- |
//! | everywhere | all that are compared |
//! | inside contact | in the truth's contact |
//! | near its border | at most [`BORDER_MM`] from where the truth's contact ends, on **both** sides |
//! | outside | neither in contact nor near its border |
//!
//! The first two overlap with the third: the inner half of the band near the border is in contact as well. Distances
//! are measured on the undeformed gel, with the camera of the truth's `profile.toml`.
//!
//! # Errors
//!
//! A depth's error is `|estimate − truth|`, mm; a flow's the distance between the places that estimate and truth lead
//! to, px. [`Errors`] has their mean, root mean square, 95th percentile and largest, and beside them bias, peaks and
//! correlation. They are given for each frame, as the mean over the frames, and over all pixels of all frames at once.
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
pub use options::Options;
pub use report::{
    Components, Errors, FieldErrors, ForceErrors, ForceReport, FrameReport, LoadErrors, PixelCounts, Region, Regions,
    Report,
};

/// How far the region near the contact's border reaches to either side, mm on the undeformed gel.
pub const BORDER_MM: f64 = 1.0;

//! Dense optical flow between two images of a textured surface, accurate to about a hundredth of a pixel.
//!
//! The flow at reference pixel `x` is the displacement of that point: `x + flow(x)` is its position in the current
//! image, px. There are two methods; both compute their templates once per reference:
//!
//! - **Dense inverse search** ([Kroeger2016]) with variational refinement ([Brox2004]): finds the displacement of
//!   patches without an initial flow, from coarse to fine. Its presets are [`SearchParams::ultrafast`],
//!   [`SearchParams::fast`] and [`SearchParams::medium`].
//! - **Coupled affine patches**, the default: patches of 16×16 px at full size. The unknowns of a patch are its
//!   displacement, the gradient of the displacement and a change of light. Each Gauss–Newton step is solved for all
//!   patches together. Neighbours are coupled; the image noise scales the coupling. Where texture is rich, the image
//!   determines the flow; where it is poor, the flow is interpolated from the neighbours.
//!
//! An [`Estimate`] contains the flow at every pixel, its predicted standard deviation in px, and whether it is valid. A
//! patch that fails has no weight, and its pixels are marked as not valid.
//!
//! ```
//! use fingervision_flow::{Estimate, FlowEstimator, FlowParams, Start};
//! use fingervision_image::{Image, Pixels, Rect};
//!
//! let pattern = |shift: usize| Pixels::Grey8(Image::from_fn(96, 64, |x, y| {
//!     let (x, y) = (((x + 8 - shift) / 3) as u32, (y / 3) as u32);
//!     ((x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663)).wrapping_mul(2_654_435_761) >> 24) as u8
//! }));
//! let mut estimator = FlowEstimator::new(96, 64, &FlowParams::default())?;
//! let (mut rest, mut pressed) = (estimator.picture(), estimator.picture());
//! rest.load(&pattern(0), Rect::whole(96, 64))?;
//! pressed.load(&pattern(2), Rect::whole(96, 64))?;
//!
//! let mut reference = estimator.reference();
//! estimator.prepare(&rest, &mut reference);
//! let mut estimate = Estimate::new(96, 64);
//! estimator.estimate(&reference, &pressed, Start::Search(None), &mut estimate);
//! assert!((estimate.flow.u.at(48, 32) - 2.0).abs() < 0.02);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [Kroeger2016]: https://arxiv.org/abs/1603.03590
//! [Brox2004]: https://doi.org/10.1007/978-3-540-24673-2_3

mod affine;
mod error;
mod estimate;
mod estimator;
mod field;
#[cfg(test)]
mod instruction_sets;
mod levels;
mod light;
mod multiply_add;
mod params;
mod picture;
mod recovery;
mod round_trip;
mod search;
mod team;

pub use affine::{FlowHistory, STRONG_GRADIENT};
pub use error::FlowError;
pub use estimate::Estimate;
pub use estimator::{FlowEstimator, Reference, Start};
pub use field::FlowField;
pub use levels::Levels;
pub use params::{AffineParams, FlowParams, Preset, ValidityParams};
pub use picture::Picture;
pub use round_trip::{invert_into, round_trip_error_into};
pub use search::{RefineParams, SearchParams};
pub use team::Team;

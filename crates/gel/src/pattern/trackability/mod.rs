//! The accuracy with which a pattern can be tracked, predicted before it is printed.
//!
//! An estimator that matches a patch of the reference with a patch of the current image cannot find its displacement
//! better than the Cramér–Rao bound allows (Kay 1993, §3; [Pan2008]). With
//! independent noise of standard deviation σ on every channel of *both* images,
//!
//! ```text
//! cov(u, v) ≥ 2 σ² G⁻¹,   G = Σ ∇I ∇Iᵀ
//! ```
//!
//! where the sum runs over the patch's pixels and channels, and I is the image without noise: the pattern in this
//! camera's image, with every pixel's exact coverage and the optics' blur. Fine cells have many edges but blur into
//! grey, coarse ones are sharp but have few edges: the best size is in between.
//!
//! The bound is that of an estimator that is already close to the solution. Where a pattern repeats, such as a grid of
//! dots, one part can be confused with another; the bound does not include this.
//!
//! [Pan2008]: https://doi.org/10.1364/OE.16.007037

mod coupling;
mod patches;
mod picture;
mod view;

use serde::Serialize;

use super::{Pattern, PatternError};
use patches::{PATCH_PX, Patch};

pub use coupling::Coupling;
pub use view::View;

/// Sampled places across and down the image.
const PLACES: usize = 3;

/// Patches across and down at every place.
const PATCHES: usize = 4;

/// A patch is poor if the standard deviation of its displacement along its worst direction exceeds this, px.
const POOR_PX: f64 = 0.1;

/// Variance that rounding to whole grey levels adds.
const ROUNDING_VARIANCE: f64 = 1.0 / 12.0;

/// Statistics of a pattern in a camera's image, over patches all over the image.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Trackability {
    /// Width and height of a patch, px.
    pub patch_px: usize,
    /// Number of patches.
    pub patches: usize,
    /// Root mean square of the image's gradient over all channels together, grey levels per px.
    pub gradient_levels_per_px: f64,
    /// Least standard deviation of the displacement of a single patch, to the right and downwards, px: the median.
    pub deviation_px: [f64; 2],
    /// The same on the gel's surface, mm.
    pub deviation_mm: [f64; 2],
    /// As `deviation_px`, of a patch with the mean structure of all, px: the start for a tracker with coupled patches.
    pub pooled_deviation_px: [f64; 2],
    /// Part of the patches whose displacement is not known to 0.1 px in every direction, 0 to 1.
    pub poor: f64,
}

/// Statistics for a pattern on the undeformed gel.
///
/// # Errors
///
/// As [`Pattern::texture`]; [`PatternError::NotSeen`] if the camera does not see the gel.
pub fn trackability(pattern: &Pattern, view: &View) -> Result<Trackability, PatternError> {
    view.validate()?;
    let texture = pattern.texture(view.gel_mm)?;
    let patches = picture::patches(&texture, view, PLACES, PATCHES);
    if patches.is_empty() {
        return Err(PatternError::NotSeen);
    }
    let noise = 2.0 * (view.noise_levels * view.noise_levels + ROUNDING_VARIANCE);
    let count = patches.len();
    let median_of = |value: &dyn Fn(&Patch) -> f64| median(patches.iter().map(value).collect());
    let deviation = |axis: usize| move |patch: &Patch| (noise * patch.inverse()[axis]).sqrt();
    let deviation_mm = |axis: usize| move |patch: &Patch| patch.mm_per_px * deviation(axis)(patch);
    let poor = patches.iter().filter(|patch| noise / patch.least_eigenvalue() > POOR_PX * POOR_PX).count();
    let mean = Patch::mean(&patches);
    let energy = (mean.structure[0] + mean.structure[2]) / (PATCH_PX * PATCH_PX) as f64;
    Ok(Trackability {
        patch_px: PATCH_PX,
        patches: count,
        gradient_levels_per_px: energy.sqrt(),
        deviation_px: [0, 1].map(|axis| median_of(&deviation(axis))),
        deviation_mm: [0, 1].map(|axis| median_of(&deviation_mm(axis))),
        pooled_deviation_px: [0, 1].map(|axis| deviation(axis)(&mean)),
        poor: poor as f64 / count as f64,
    })
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { 0.5 * (values[middle - 1] + values[middle]) }
}

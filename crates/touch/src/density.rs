//! Density: how close together the points of the surface lie in the image.
//!
//! Every reference pixel `x` moves to `x' = x + flow(x)` and carries a Gaussian of standard deviation σ there
//! ([Du2021]). Their sum `D(y) = 1/(2πσ²) Σ exp(−|y − x'|² / 2σ²)` is 1 where the surface is at rest and `1/det J` where
//! it is stretched evenly by `J`: the density falls where a press brings the surface nearer to the camera, and where it
//! spreads for any other reason.
//!
//! **Grid.** `D` is a field of the current image. Fields of a reading belong to points of the gel, so `D` is read at the
//! moved places: `D(x + flow(x))`, on the reference grid. [`DensityEstimator::current_density_into`] gives `D` itself.
//!
//! **Border.** The gel continues outside the image, its points do not: at rest `D` falls to ½ at the image's edge and to
//! ¼ in its corners. Which neighbours are missing is a property of the *reference* pixel, wherever it moves, so the
//! density is divided there by its value at zero flow, `D₀(x)`. A shifted surface then has density 1 up to its last
//! pixel. Within 3σ of the border a stretch still reads close to `1/det J`, but not exactly: the missing neighbours have
//! moved too.
//!
//! **Outside the image.** A point that moves outside the image still adds its Gaussian to those inside, exactly as in the
//! definition. Its own density belongs to a place that the camera does not see: it reads as at rest and invalid. Gel that
//! enters the image has no reference pixel and adds nothing; the points that it pushes inwards are those of the border,
//! for whose missing neighbours `D₀` already accounts.
//!
//! [Du2021]: https://doi.org/10.1109/LRA.2021.3061306

mod exact;
mod fast;
mod params;
mod smoothing;
mod spacing;
mod spline;
#[cfg(test)]
mod tests;

use fearless_simd::{Level, dispatch, prelude::*};
use fearless_simd_macros::simd;
use fingervision_flow::FlowField;
use fingervision_image::Image;

pub use params::{DensityMethod, DensityParams};

use crate::ParameterError;

use fast::SplineSum;
use spacing::Spacings;

/// The density of one flow, on the reference grid.
#[derive(Debug, Clone, PartialEq)]
pub struct DensityField {
    /// The feature `1 − density`, dimensionless: 0 at rest, positive where the surface expands, negative where it
    /// contracts.
    pub feature: Image<f32>,
    /// 1 where the feature is valid; 0 where a neighbour lies 3σ or more away, where the point has left the image, and
    /// where the flow is not finite.
    pub valid: Image<u8>,
    /// M: the largest distance between the moved places of two neighbouring pixels, px; 1 at rest.
    pub largest_spacing_px: f32,
    /// Whether M reaches 3σ: somewhere the Gaussians do not overlap.
    pub has_gap: bool,
}

impl DensityField {
    /// The field of a surface at rest.
    #[must_use]
    pub fn at_rest(width: usize, height: usize) -> Self {
        Self {
            feature: Image::filled(width, height, 0.0),
            valid: Image::filled(width, height, 1),
            largest_spacing_px: 1.0,
            has_gap: false,
        }
    }
}

/// Turns flows of one size into densities.
///
/// Owns its scratch memory: [`DensityMethod::Fast`] allocates nothing per frame. On one machine the same flow always gives
/// the same bits; instruction sets differ in the last ones.
#[derive(Debug, Clone)]
pub struct DensityEstimator {
    width: usize,
    height: usize,
    sigma: f64,
    level: Level,
    /// The sum by splines; `None` sums pair by pair.
    splines: Option<SplineSum>,
    /// `1/D₀` is the product of a profile along x and one along y.
    inverse_border: (Vec<f32>, Vec<f32>),
    spacings: Spacings,
    /// 1 for every point of a row that lies in the current image, else 0.
    in_sight: Vec<f32>,
}

impl DensityEstimator {
    /// An estimator for flows of this size, px.
    ///
    /// # Errors
    ///
    /// [`ParameterError`] if a parameter is out of range.
    ///
    /// # Panics
    ///
    /// If the size is zero.
    pub fn new(width: usize, height: usize, params: &DensityParams) -> Result<Self, ParameterError> {
        Self::with_level(width, height, params, Level::new())
    }

    fn with_level(width: usize, height: usize, params: &DensityParams, level: Level) -> Result<Self, ParameterError> {
        params.validate()?;
        assert!(width > 0 && height > 0, "an image of {width}x{height} px has no density");
        let sigma = params.sigma_px;
        let is_fast = params.method == DensityMethod::Fast;
        Ok(Self {
            width,
            height,
            sigma,
            level,
            splines: is_fast.then(|| SplineSum::new(width, height, sigma, level)),
            inverse_border: (inverse_border(width, sigma), inverse_border(height, sigma)),
            spacings: Spacings::new(width),
            in_sight: vec![0.0; width],
        })
    }

    /// Writes the density feature `1 − D(x + flow(x)) / D₀(x)` of a flow, and where it is valid.
    ///
    /// # Panics
    ///
    /// If the flow or the field differs in size from the estimator.
    pub fn estimate_into(&mut self, flow: &FlowField, field: &mut DensityField) {
        let size = (self.width, self.height);
        assert_eq!((flow.size(), flow.v.size()), (size, size), "size of the flow");
        assert_eq!((field.feature.size(), field.valid.size()), (size, size), "size of the density");
        match &mut self.splines {
            Some(splines) => splines.at_points_into(flow, &mut field.feature),
            None => exact::at_points_into(flow, self.sigma, &mut field.feature),
        }
        dispatch!(self.level, simd => self.finish(simd, flow, field));
        field.largest_spacing_px = self.spacings.largest_px();
        field.has_gap = field.largest_spacing_px >= self.limit_px();
    }

    /// Writes the density `D` of a flow at every pixel of the current image, by its definition: not normalised at the
    /// border, 1 at rest, dimensionless.
    ///
    /// # Panics
    ///
    /// If the flow or the image differs in size from the estimator.
    pub fn current_density_into(&mut self, flow: &FlowField, density: &mut Image<f32>) {
        let size = (self.width, self.height);
        assert_eq!((flow.size(), flow.v.size()), (size, size), "size of the flow");
        assert_eq!(density.size(), size, "size of the density");
        match &mut self.splines {
            Some(splines) => splines.at_pixels_into(flow, density),
            None => exact::at_pixels_into(flow, self.sigma, density),
        }
    }

    /// The spacing at which neighbouring Gaussians no longer overlap: 3σ, px.
    fn limit_px(&self) -> f32 {
        (3.0 * self.sigma) as f32
    }

    /// Turns the density at the moved places, in `field.feature`, into the feature, and marks where it is valid.
    #[simd]
    fn finish<S: Simd>(&mut self, simd: S, flow: &FlowField, field: &mut DensityField) {
        let limit = self.limit_px();
        let rows = field.feature.rows_mut().zip(field.valid.rows_mut());
        for (y, (feature, valid)) in rows.enumerate() {
            let in_sight = &mut self.in_sight;
            mark_in_sight(simd, flow, y, in_sight);
            let (across, down) = (&self.inverse_border.0, self.inverse_border.1[y]);
            for ((feature, &in_sight), across) in feature.iter_mut().zip(&*in_sight).zip(across) {
                *feature = if in_sight > 0.0 { 1.0 - *feature * (across * down) } else { 0.0 };
            }
            self.spacings.measure(simd, flow, y);
            self.spacings.mark_valid(simd, limit, in_sight, valid);
        }
    }
}

/// Marks with 1 the points of row `y` that lie on a pixel of the current image, with 0 all others.
#[simd]
#[expect(clippy::needless_bitwise_bool, reason = "without branches the loop is vectorised")]
fn mark_in_sight<S: Simd>(_: S, flow: &FlowField, y: usize, in_sight: &mut [f32]) {
    let (right, bottom) = (flow.u.width() as f32 - 0.5, flow.u.height() as f32 - 0.5);
    let flow = flow.u.row(y).iter().zip(flow.v.row(y));
    for (x, (in_sight, (u, v))) in in_sight.iter_mut().zip(flow).enumerate() {
        // A signed integer of 32 bits is converted in one instruction.
        let (x, y) = ((x as u32).cast_signed() as f32 + u, y as f32 + v);
        let is_inside = (x >= -0.5) & (x <= right) & (y >= -0.5) & (y <= bottom);
        *in_sight = if is_inside { 1.0 } else { 0.0 };
    }
}

/// One over the density at rest along one axis: `1 / Σ g(x − i)` over the `length` pixels `i`.
fn inverse_border(length: usize, sigma: f64) -> Vec<f32> {
    let gaussian = |distance: f64| (-0.5 * (distance / sigma).powi(2)).exp() / (sigma * std::f64::consts::TAU.sqrt());
    let at_rest = |x: usize| (0..length).map(|i| gaussian(x as f64 - i as f64)).sum::<f64>();
    (0..length).map(|x| (1.0 / at_rest(x)) as f32).collect()
}

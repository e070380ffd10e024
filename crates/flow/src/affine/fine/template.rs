//! The equations of the fine patches of a reference.

use super::cell::template_moments;
use super::grid::{CornerWeights, FineGrid, overlap, window_weights};
use crate::affine::noise::Noise;
use crate::affine::own_variance::{noise_gradient, own_variance};
use crate::affine::template::{MOMENTS, PatchEquations, Template};
use fearless_simd::{Level, Simd, dispatch};

/// The equations of all fine patches of a reference.
#[derive(Debug, Clone)]
pub(crate) struct FineTemplate {
    pub(super) grid: FineGrid,
    /// For every node; zero if its window reaches beyond the image.
    pub(super) equations: Vec<PatchEquations>,
    /// Variance of the displacement from the patch alone, px².
    own_variance: Vec<OwnVariance>,
    /// The noise that the patches are coupled for, and that of the pixels.
    pub(super) noise: Noise,
    /// Factor on the patches' equations: one over the noise variance and their overlap.
    pub(super) scale: f32,
}

/// Variances of a patch's displacement from its own pixels, px²: with slopes that the prior limits, and with slopes that it hardly limits,
/// as at a rim. They differ where the texture does not determine the slopes.
#[derive(Debug, Clone, Copy)]
struct OwnVariance {
    bound: f32,
    loose: f32,
}

/// The bond of a patch for which [`OwnVariance::loose`] is computed.
const LEAST_BOND: f32 = 0.001;
/// The bond at which the variance has grown by half as much as without any bond; measured on speckle patterns.
const HALF_BOND: f32 = 0.0005;

impl OwnVariance {
    /// The variance of a patch whose bonds to its neighbours are `bond` on average, 0 to 1.
    fn at(self, bond: f32) -> f32 {
        let part = ((HALF_BOND + LEAST_BOND) / (HALF_BOND + bond)).min(1.0);
        self.bound + part * (self.loose - self.bound)
    }
}

impl FineTemplate {
    /// An empty template for pictures of this size. Nothing is written to its memory until a reference is prepared.
    pub(crate) fn new(width: usize, height: usize) -> Self {
        let grid = FineGrid::over(width, height);
        Self {
            grid,
            equations: Vec::with_capacity(grid.nodes()),
            own_variance: Vec::with_capacity(grid.nodes()),
            noise: Noise::of(1.0),
            scale: 1.0,
        }
    }

    /// Sets the equations of a new reference, whose pixels are in `template`.
    pub(crate) fn prepare(&mut self, level: Level, template: &Template, channels: usize) {
        let weights = window_weights();
        let mut sums = vec![[0.0_f32; MOMENTS]; self.grid.nodes()];
        dispatch!(level, simd => self.sum(simd, template, channels, &weights, &mut sums));
        self.equations.clear();
        self.equations.extend(sums.iter().map(|sums| PatchEquations::new(|moment| sums[moment])));
    }

    /// Computes what follows from the equations and from the noise of both pictures; `slope_stiffness` is the curvature stiffness of a pair with bond 1.
    pub(crate) fn complete(&mut self, noise: Noise, slope_stiffness: f32) {
        self.noise = noise;
        self.scale = 1.0 / (noise.variance() * overlap());
        let (pixel_variance, scale) = (noise.pixels.powi(2), self.scale);
        let variance = |equations: &PatchEquations| {
            let noise = noise_gradient(equations.samples, pixel_variance);
            let with_stiffness = |stiffness| own_variance(|entry| equations.normal[entry], noise, scale, stiffness);
            OwnVariance { bound: with_stiffness(slope_stiffness), loose: with_stiffness(LEAST_BOND * slope_stiffness) }
        };
        self.own_variance.clear();
        self.own_variance.extend(self.equations.iter().map(variance));
    }

    /// Variance of a patch's displacement from its own pixels, px²; `bond` is the mean of those to its neighbours, 0 to 1.
    pub(super) fn own_variance(&self, place: usize, bond: f32) -> f32 {
        self.own_variance[place].at(bond)
    }

    /// Sums the moments over the windows.
    #[inline(always)]
    fn sum<S: Simd>(
        &self,
        simd: S,
        template: &Template,
        channels: usize,
        weights: &CornerWeights<6>,
        sums: &mut [[f32; MOMENTS]],
    ) {
        for cell in self.grid.cells() {
            let moments = template_moments(simd, template, channels, weights, self.grid.upper_left(cell));
            for (corner, moments) in self.grid.corners(cell).into_iter().zip(moments) {
                for (sum, moment) in sums[corner].iter_mut().zip(moments) {
                    *sum += moment;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::affine::grid::PatchGrid;
    use fingervision_image::Image;

    const SIZE: usize = 48;
    const NOISE_LEVELS: f32 = 2.0;
    const STIFFNESS: f32 = 8000.0;

    /// How much the variance of the patch in the middle grows from full bonds to hardly any.
    fn growth(level_at: impl FnMut(usize, usize) -> f32) -> f32 {
        let image = Image::from_fn(SIZE, SIZE, level_at);
        let mut template = Template::new(PatchGrid::over(SIZE, SIZE), 1, 1);
        template.prepare(Level::new(), std::slice::from_ref(&image));
        let mut fine = FineTemplate::new(SIZE, SIZE);
        fine.prepare(Level::new(), &template, 1);
        fine.complete(Noise::of(NOISE_LEVELS), STIFFNESS);
        let place = fine.grid.nodes() / 2 + fine.grid.columns / 2;
        let [bound, half, loose] = [1.0, HALF_BOND, 0.0].map(|bond| fine.own_variance(place, bond));
        assert!(bound > 0.0 && bound <= half && half <= loose && loose < 1.0, "{bound}, {half}, {loose} px²");
        loose / bound
    }

    #[test]
    fn a_patch_with_texture_in_a_corner_alone_depends_on_its_neighbours() {
        let textured = growth(|x, y| ((7919 * x + 104_729 * y + 31 * x * y) % 251) as f32);
        assert!(textured < 1.5, "slopes are determined by the texture: {textured}");
        // A dark spot beside the patch's middle, nothing else.
        let place = |at: usize| at as f32 - 27.0;
        let corner = growth(|x, y| if place(x).hypot(place(y)) < 2.5 { 30.0 } else { 220.0 });
        assert!(corner > 3.0, "the slopes are those of the neighbours: {corner}");
    }
}

//! The equations of the fine patches of a reference.

use super::cell::template_moments;
use super::grid::{CornerWeights, FineGrid, window_weights};
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
    pub(super) own_variance: Vec<f32>,
}

impl FineTemplate {
    /// An empty template for pictures of this size. Nothing is written to its memory until a reference is prepared.
    pub(crate) fn new(width: usize, height: usize) -> Self {
        let grid = FineGrid::over(width, height);
        Self { grid, equations: Vec::with_capacity(grid.nodes()), own_variance: Vec::with_capacity(grid.nodes()) }
    }

    /// Prepares a new reference, whose pixels are in `template`. `noise_variance` is that of one image, `scale` is one
    /// over the noise variance of two and the overlap, `slope_stiffness` the curvature stiffness of a pair with bond 1.
    pub(crate) fn prepare(
        &mut self,
        level: Level,
        template: &Template,
        channels: usize,
        noise_variance: f32,
        scale: f32,
        slope_stiffness: f32,
    ) {
        let weights = window_weights();
        let mut sums = vec![[0.0_f32; MOMENTS]; self.grid.nodes()];
        dispatch!(level, simd => self.sum(simd, template, channels, &weights, &mut sums));
        self.equations.clear();
        self.equations.extend(sums.iter().map(|sums| PatchEquations::new(|moment| sums[moment])));
        let variance = |equations: &PatchEquations| {
            let noise = noise_gradient(equations.samples, noise_variance);
            own_variance(|entry| equations.normal[entry], noise, scale, slope_stiffness)
        };
        self.own_variance.clear();
        self.own_variance.extend(self.equations.iter().map(variance));
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

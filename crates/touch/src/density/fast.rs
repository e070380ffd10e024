//! The density by splines: spread the points, smooth the grid, read it at the points.
//!
//! Every moved point is spread over 4×4 nodes of the pixel grid by a cubic B-spline, the grid is smoothed by a separable
//! kernel, and the result is interpolated between its nodes by a cubic B-spline again. The kernel is chosen so that the
//! three together give the Gaussian; the remaining effect of the grid is below 5e-4 at σ = 2 px.
//!
//! The order of sums does not depend on the width of the registers, but multiply and add are fused where the processor
//! supports it: instruction sets differ in the last bits.

use fearless_simd::{Level, dispatch, prelude::*};
use fearless_simd_macros::simd;
use fingervision_flow::FlowField;
use fingervision_image::Image;

use super::smoothing::{self, smooth};
use super::spline::{Grid, SUPPORT, Scratch, read_row, spread_row};

/// Sums Gaussians over images of one size.
#[derive(Debug, Clone)]
pub(super) struct SplineSum {
    level: Level,
    grid: Grid,
    /// Width of the rim of the grid whose smoothed values nothing reads, in nodes.
    border: usize,
    taps: Vec<f32>,
    spread: Vec<f32>,
    smoothed: Vec<f32>,
    smoothing_row: Vec<f32>,
    scratch: Scratch,
}

impl SplineSum {
    /// A sum of Gaussians of standard deviation `sigma` px over images of this size.
    pub(super) fn new(width: usize, height: usize, sigma: f64, level: Level) -> Self {
        // A place inside the image reads nodes up to 3 px outside the image; the taps carry there what lies `reach` px
        // farther out, and a block that touches such a node begins up to 4 px before it.
        let border = smoothing::reach(sigma) + SUPPORT - 1;
        let margin = border + 3;
        let grid = Grid { columns: width + 2 * margin, rows: height + 2 * margin, margin };
        let nodes = grid.columns * grid.rows;
        Self {
            level,
            grid,
            border,
            taps: smoothing::taps(sigma),
            spread: vec![0.0; nodes],
            smoothed: vec![0.0; nodes],
            smoothing_row: vec![0.0; grid.columns],
            scratch: Scratch::new(),
        }
    }

    /// Writes the density at the moved place of every reference pixel. At a place more than half a pixel outside the
    /// image it is too small.
    pub(super) fn at_points_into(&mut self, flow: &FlowField, density: &mut Image<f32>) {
        dispatch!(self.level, simd => self.at_points(simd, flow, density));
    }

    /// Writes the density at every pixel of the current image.
    pub(super) fn at_pixels_into(&mut self, flow: &FlowField, density: &mut Image<f32>) {
        dispatch!(self.level, simd => self.spread_and_smooth(simd, flow));
        let Grid { columns, margin, .. } = self.grid;
        for (y, density) in density.rows_mut().enumerate() {
            for (x, density) in density.iter_mut().enumerate() {
                // At a node the spline weights its neighbours 1/6, 4/6, 1/6.
                let across = |y: usize| {
                    let nodes = &self.smoothed[y * columns + x + margin - 1..][..3];
                    (nodes[0] + 4.0 * nodes[1] + nodes[2]) / 6.0
                };
                let y = y + margin;
                *density = (across(y - 1) + 4.0 * across(y) + across(y + 1)) / 6.0;
            }
        }
    }

    #[simd]
    fn at_points<S: Simd>(&mut self, simd: S, flow: &FlowField, density: &mut Image<f32>) {
        self.spread_and_smooth(simd, flow);
        let (u, v) = (flow.u.rows(), flow.v.rows());
        for (y, ((density, u), v)) in density.rows_mut().zip(u).zip(v).enumerate() {
            read_row(simd, &mut self.scratch, self.grid, (y, u, v), &self.smoothed, density);
        }
    }

    #[simd]
    fn spread_and_smooth<S: Simd>(&mut self, simd: S, flow: &FlowField) {
        self.spread.fill(0.0);
        for (y, (u, v)) in flow.u.rows().zip(flow.v.rows()).enumerate() {
            spread_row(simd, &mut self.scratch, self.grid, (y, u, v), &mut self.spread);
        }
        let shape = (self.grid.columns, self.border);
        smooth(simd, &self.taps, shape, &self.spread, &mut self.smoothed, &mut self.smoothing_row);
    }
}

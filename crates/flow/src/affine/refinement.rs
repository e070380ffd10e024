//! Gauss–Newton steps of all patches at once.
//!
//! One step warps the current picture onto the reference with the current flow, forms every patch's right-hand side from
//! the residual, solves the coupled system and composes the increments with the flow. Rows are processed in bands of one
//! stride, so that a patch's data are still in the cache when its window is complete.

use super::bonds::Stiffness;
use super::coupling::{Coupling, System};
use super::expander::Expander;
use super::grid::{LANES, MARGIN, PatchGrid, STRIDE};
use super::moments::{Band, Window, sum_columns, sum_rows, sum_rows_twice};
use super::nodes::{NodeField, UNKNOWNS};
use super::own_variance::own_variances;
use super::template::{BlurredTemplate, Template};
use super::texel::{Texel, locate, products};
use crate::FlowField;
use fearless_simd::{Level, Simd, dispatch, f32x16, prelude::*};
use fearless_simd_macros::simd;
use fingervision_image::Image;

/// The current picture on one level, and the gain that brings its mean to the reference's.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Current<'a, T> {
    pub(crate) image: &'a Image<T>,
    pub(crate) gain: f32,
}

/// Number of products that are summed over every patch: two for the gradient, two for light, one for the energy.
const PRODUCTS: usize = 5;

/// A patch's step is divided by its contrast, limited to this range. If the contrast is much lower, the patch has a
/// wrong position and its step is unreliable.
pub(super) const CONTRASTS: (f32, f32) = (0.4, 1.5);

/// Longest increment of a failed patch, px, and of its gradient, px per stride.
const LONGEST_PULL: f32 = 4.0;

/// Square of the error that remains after the last step, relative to the square of this step. Each step is three to ten
/// times shorter than the one before.
pub(super) const REMAINING_ERROR: f32 = 0.05;

/// Square of the error of a flow found by the search alone, relative to the square of the step that the patches would
/// take from it.
const SEARCH_ERROR: f32 = 2.0;

/// Sum of the squared residuals of a clearly worse match, relative to that of the other.
const CLEARLY_WORSE: f32 = 1.5;

/// State of the refinement for one picture size.
#[derive(Debug, Clone)]
pub(crate) struct Refinement {
    pub(super) grid: PatchGrid,
    pub(super) level: Level,
    window: Window,
    pub(super) noise_variance: f32,
    expander: Expander,
    pub(super) coupling: Coupling,
    bands: [[Vec<f32>; PRODUCTS]; 2],
    positions: [Vec<f32>; 2],
    row_sums: [Vec<f32>; 2],
    pub(super) gradient: [Vec<f32>; UNKNOWNS],
    pub(super) light: [Vec<f32>; 2],
    /// Contrast of each patch relative to the template's: 1 if only the light of the whole picture changed.
    pub(super) contrast: Vec<f32>,
    pub(super) energy: Vec<f32>,
    /// Residual per sample, grey levels².
    pub(super) mean_energy: Vec<f32>,
    /// Square of the error that further steps would correct, px².
    pub(super) remaining_error: Vec<f32>,
    /// Whether the patch's centre lies in the current image.
    pub(super) is_inside: Vec<bool>,
    pub(super) trust: Vec<f32>,
    pub(super) increment: NodeField,
}

impl Refinement {
    pub(crate) fn new(grid: PatchGrid, level: Level, noise: f32, stiffness: Stiffness) -> Self {
        let plane = || vec![0.0; grid.plane_len()];
        let line = || vec![0.0; grid.padded_width()];
        let band = || std::array::from_fn(|_| vec![0.0; STRIDE * grid.padded_width()]);
        Self {
            grid,
            level,
            window: Window::new(),
            // Both pictures have noise.
            noise_variance: 2.0 * noise * noise,
            expander: Expander::new(grid),
            coupling: Coupling::new(grid, stiffness),
            bands: [band(), band()],
            positions: [line(), line()],
            row_sums: [line(), line()],
            gradient: std::array::from_fn(|_| plane()),
            light: [plane(), plane()],
            contrast: vec![1.0; grid.plane_len()],
            energy: plane(),
            mean_energy: plane(),
            remaining_error: plane(),
            is_inside: vec![true; grid.plane_len()],
            trust: vec![1.0; grid.plane_len()],
            increment: NodeField::zero(grid),
        }
    }

    /// Factor on the normal equations: one over the noise variance and the overlap of the patches.
    pub(super) fn scale(&self) -> f32 {
        1.0 / (self.noise_variance * self.window.overlap())
    }

    /// Prepares a new reference.
    pub(crate) fn prepare<T: Texel>(&self, picture: &Image<T>, template: &mut Template) {
        template.prepare(self.level, picture);
        self.complete(template);
    }

    /// Computes what follows from the normal equations of a template.
    pub(super) fn complete(&self, template: &mut Template) {
        let scale = self.scale();
        self.coupling.set_coarse_blocks(&template.normal, scale, &mut template.coarse);
        let slope_stiffness = self.coupling.stiffness().curvature;
        own_variances(self.grid, &template.normal, scale, slope_stiffness, &mut template.own_variance);
    }

    /// Prepares the template as a picture shows it that is exposed during `part` of the motion; see [`BlurredTemplate::set`].
    pub(crate) fn blur(
        &self,
        sharp: &Template,
        motion: (&FlowField, &FlowField),
        part: f32,
        out: &mut BlurredTemplate,
    ) {
        out.set(self.level, sharp, motion, part);
        self.complete(&mut out.template);
    }

    /// One Gauss–Newton step from `field`.
    pub(crate) fn step<T: Texel>(
        &mut self,
        template: &Template,
        current: Current<'_, T>,
        field: &mut NodeField,
        iterations: usize,
    ) {
        let level = self.level;
        dispatch!(level, simd => self.solve(simd, template, current, field, iterations));
        self.discard_leaps();
        self.set_remaining_error(REMAINING_ERROR);
        field.compose(&self.increment);
    }

    /// Sets the increments of failed patches that are too long to zero. Only the coupling moves such a patch. Where the flow
    /// is rough the coupling is so weak that the few iterations leave an arbitrary increment.
    fn discard_leaps(&mut self) {
        let increment = &mut self.increment.planes;
        for (node, trust) in self.trust.iter().enumerate() {
            if *trust <= 0.0 && increment.iter().any(|plane| plane[node].abs() > LONGEST_PULL) {
                for plane in increment.iter_mut() {
                    plane[node] = 0.0;
                }
            }
        }
    }

    /// For every node, whether the picture matches clearly worse at `field` than at `other`. Uses the mean energy as scratch
    /// memory, until the patches are judged again.
    pub(crate) fn is_worse_at<T: Texel>(
        &mut self,
        template: &Template,
        current: Current<'_, T>,
        field: &NodeField,
        other: &NodeField,
    ) -> impl Fn(usize) -> bool {
        let level = self.level;
        for field in [other, field] {
            std::mem::swap(&mut self.energy, &mut self.mean_energy);
            self.expander.prepare(field);
            dispatch!(level, simd => self.measure(simd, template, current, field));
        }
        |node| self.energy[node] > CLEARLY_WORSE * self.mean_energy[node]
    }

    /// Measures the residual at `field` without changing it. The step that the patches would take counts as its error.
    pub(crate) fn inspect<T: Texel>(
        &mut self,
        template: &Template,
        current: Current<'_, T>,
        field: &NodeField,
        iterations: usize,
    ) {
        let level = self.level;
        self.trust_all();
        dispatch!(level, simd => self.solve(simd, template, current, field, iterations));
        self.set_remaining_error(SEARCH_ERROR);
        for plane in &mut self.increment.planes {
            plane.fill(0.0);
        }
    }

    /// Writes the increment of a step from `field`.
    #[inline(always)]
    fn solve<S: Simd, T: Texel>(
        &mut self,
        simd: S,
        template: &Template,
        current: Current<'_, T>,
        field: &NodeField,
        iterations: usize,
    ) {
        self.expander.prepare(field);
        self.measure(simd, template, current, field);
        self.form_right(template);
        let system = System {
            normal: &template.normal,
            coarse: &template.coarse,
            scale: self.scale(),
            trust: &self.trust,
            right: &self.gradient,
        };
        self.coupling.solve(simd, &system, field, &mut self.increment, iterations);
    }

    /// Adds the difference between a flow and the patches' own field `smooth` to the error: it is detail that patches
    /// cannot represent.
    pub(crate) fn add_fine_error(&mut self, flow: &FlowField, smooth: &FlowField) {
        let PatchGrid { width, height, columns, .. } = self.grid;
        for y in 0..height {
            let node = y / STRIDE * columns;
            let rows = [&flow.u, &flow.v, &smooth.u, &smooth.v].map(|plane| plane.row(y));
            for x in 0..width {
                let [u, v, smooth_u, smooth_v] = rows.map(|row| row[x]);
                let square = (u - smooth_u).powi(2) + (v - smooth_v).powi(2);
                self.remaining_error[node + x / STRIDE] += square / (STRIDE * STRIDE) as f32;
            }
        }
    }

    /// Sets the square of the remaining error to a part of the increment's square.
    fn set_remaining_error(&mut self, part: f32) {
        let [u, _, _, v, ..] = &self.increment.planes;
        for (remaining_error, (u, v)) in self.remaining_error.iter_mut().zip(u.iter().zip(v)) {
            *remaining_error = part * (u * u + v * v);
        }
    }

    /// Sums the products of residual and template over every patch.
    #[inline(always)]
    fn measure<S: Simd, T: Texel>(&mut self, simd: S, template: &Template, current: Current<'_, T>, field: &NodeField) {
        self.fill_band(simd, template, current, field, 0);
        for j in 0..self.grid.rows {
            self.fill_band(simd, template, current, field, j + 1);
            let nodes = j * self.grid.columns..(j + 1) * self.grid.columns;
            let step = template.row_step;
            let upper = &self.bands[j % 2];
            let lower = &self.bands[(j + 1) % 2];
            for component in 0..2 {
                let [plain, first] = &mut self.row_sums;
                let band = Band { halves: [&upper[component], &lower[component]], step };
                sum_rows_twice(simd, &self.window, band, [plain, first]);
                let gradient = &mut self.gradient[3 * component..];
                sum_columns(simd, &self.window, 0, plain, &mut gradient[0][nodes.clone()]);
                sum_columns(simd, &self.window, 1, plain, &mut gradient[1][nodes.clone()]);
                sum_columns(simd, &self.window, 0, first, &mut gradient[2][nodes.clone()]);
            }
            let [gain, offset] = &mut self.light;
            let [sums, _] = &mut self.row_sums;
            for (k, plane) in [gain, offset, &mut self.energy].into_iter().enumerate() {
                let band = Band { halves: [&upper[2 + k], &lower[2 + k]], step };
                sum_rows(simd, &self.window, 0, band, sums);
                sum_columns(simd, &self.window, 0, sums, &mut plane[nodes.clone()]);
            }
        }
    }

    /// Warps the current picture onto one row of cells and multiplies the residual with the template.
    #[inline(always)]
    fn fill_band<S: Simd, T: Texel>(
        &mut self,
        simd: S,
        template: &Template,
        current: Current<'_, T>,
        field: &NodeField,
        cell_row: usize,
    ) {
        for k in (0..STRIDE).step_by(template.row_step) {
            let row = cell_row * STRIDE + k;
            let band = &mut self.bands[cell_row % 2];
            let start = k * self.grid.padded_width();
            if !(MARGIN..MARGIN + self.grid.height).contains(&row) {
                for plane in band {
                    plane[start..][..self.grid.padded_width()].fill(0.0);
                }
                continue;
            }
            let [xs, ys] = &mut self.positions;
            self.expander.row(field, row, [xs, ys]);
            to_positions(self.grid, row, xs, ys);
            multiply_row(simd, template, current, row, [xs, ys], band, start);
        }
    }

    /// Eliminates the change of light from the gradient sums and scales them by the noise.
    ///
    /// If a patch has γ times the contrast of the template, `I(x + u) = γ T(x − δ)`, its sums give the step `γ δ`. So
    /// they are divided by γ, which is the regression coefficient of the picture on the template. If the position of a
    /// patch is wrong by δ, γ is the autocorrelation of the texture at δ, and the division corrects the step for the
    /// curvature of the texture.
    fn form_right(&mut self, template: &Template) {
        let scale = self.scale();
        let [gain, offset] = &self.light;
        let [d00, d01, _] = &template.light_inverse;
        for (node, contrast) in self.contrast.iter_mut().enumerate() {
            *contrast = 1.0 - (d00[node] * gain[node] + d01[node] * offset[node]);
        }
        for (gradient, by_light) in self.gradient.iter_mut().zip(&template.light_gain) {
            for (node, gradient) in gradient.iter_mut().enumerate() {
                let explained = by_light[0][node] * gain[node] + by_light[1][node] * offset[node];
                let contrast = self.contrast[node].clamp(CONTRASTS.0, CONTRASTS.1);
                *gradient = scale * (*gradient - explained) / contrast;
            }
        }
    }

    /// Writes the flow at every pixel.
    pub(crate) fn expand(&mut self, field: &NodeField, flow: &mut FlowField) {
        let level = self.level;
        dispatch!(level, simd => self.expand_simd(simd, field, flow));
    }

    #[inline(always)]
    fn expand_simd<S: Simd>(&mut self, simd: S, field: &NodeField, flow: &mut FlowField) {
        let _ = simd;
        self.expander.prepare(field);
        let [u, v] = &mut self.positions;
        for y in 0..self.grid.height {
            self.expander.row(field, y + MARGIN, [u, v]);
            flow.u.row_mut(y).copy_from_slice(&u[MARGIN..][..self.grid.width]);
            flow.v.row_mut(y).copy_from_slice(&v[MARGIN..][..self.grid.width]);
        }
    }
}

/// Converts displacements along padded row `row` to positions in the current picture. Padding gets a position outside
/// it.
#[inline(always)]
#[expect(clippy::cast_possible_wrap, reason = "the columns of an image")]
fn to_positions(grid: PatchGrid, row: usize, xs: &mut [f32], ys: &mut [f32]) {
    let y = row as f32 - MARGIN as f32;
    for (column, (x, v)) in xs.iter_mut().zip(ys.iter_mut()).enumerate() {
        *x += (column as i32 - MARGIN as i32) as f32; // integers of 32 bits are converted in one instruction
        *v += y;
    }
    xs[..MARGIN].fill(-1.0);
    xs[MARGIN + grid.width..].fill(-1.0);
    ys[MARGIN + grid.width..].fill(0.0);
}

#[simd]
fn multiply_row<S: Simd, T: Texel>(
    simd: S,
    template: &Template,
    current: Current<'_, T>,
    row: usize,
    [xs, ys]: [&[f32]; 2],
    band: &mut [Vec<f32>; PRODUCTS],
    start: usize,
) {
    for column in (0..xs.len()).step_by(LANES) {
        let x = f32x16::from_slice(simd, &xs[column..][..LANES]);
        let y = f32x16::from_slice(simd, &ys[column..][..LANES]);
        let (taps, inside) = locate(simd, x, y, current.image.size());
        let products =
            products(simd, current.image, current.gain, &taps, |channel| template.block(channel, column, row));
        let [gx, gy] = products.gradient;
        let [gain, offset] = products.light;
        for (plane, product) in band.iter_mut().zip([gx, gy, gain, offset, products.energy]) {
            (product * inside).store_slice(&mut plane[start + column..][..LANES]);
        }
    }
}

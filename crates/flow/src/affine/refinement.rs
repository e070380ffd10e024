//! Gauss–Newton steps of all patches at once.
//!
//! One step warps the current picture onto the reference with the current flow, forms every patch's right-hand side from
//! the residual, solves the coupled system and composes the increments with the flow. Rows are processed in bands of one
//! stride, so that a patch's data are still in the cache when its window is complete.

use super::bonds::Stiffness;
use super::coupling::{Coupling, System};
use super::expander::Expander;
use super::grid::{PatchGrid, STRIDE};
use super::measurement::{Measurement, Strip, Sums};
use super::moments::Window;
use super::nodes::{NodeField, UNKNOWNS};
use super::noise::Noise;
use super::own_variance::{noise_gradient, own_variance, signal};
use super::products::Current;
use super::template::{BlurredTemplate, Template};
use super::visible::{LEAST_VISIBLE, VisiblePart};
use crate::{FlowField, Team};
use fearless_simd::{Level, Simd, dispatch};

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
    expander: Expander,
    pub(super) coupling: Coupling,
    /// Memory for the upper and the lower half of the picture.
    strips: [Strip; 2],
    team: Team,
    pub(super) gradient: [Vec<f32>; UNKNOWNS],
    pub(super) light: [Vec<f32>; 2],
    /// Contrast of each patch relative to the template's: 1 if only the light of the whole picture changed.
    pub(super) contrast: Vec<f32>,
    pub(super) energy: Vec<f32>,
    /// Residual per sample, grey levels².
    pub(super) mean_energy: Vec<f32>,
    /// Square of the error that further steps would correct, px².
    pub(super) remaining_error: Vec<f32>,
    visible_part: VisiblePart,
    /// The part of each patch that lies in the current image, 0 to 1.
    pub(super) visible: Vec<f32>,
    /// The nodes whose patch may lie partly outside.
    pub(super) partial: Vec<usize>,
    /// Whether enough of the patch lies in the current image.
    pub(super) is_inside: Vec<bool>,
    pub(super) trust: Vec<f32>,
    /// The trust, times the part of each patch's gradient that is not noise.
    weight: Vec<f32>,
    pub(super) increment: NodeField,
}

impl Refinement {
    pub(crate) fn new(grid: PatchGrid, level: Level, stiffness: Stiffness) -> Self {
        let plane = || vec![0.0; grid.plane_len()];
        Self {
            grid,
            level,
            window: Window::new(),
            expander: Expander::new(grid),
            coupling: Coupling::new(grid, stiffness),
            strips: std::array::from_fn(|_| Strip::new(grid)),
            team: Team::default(),
            gradient: std::array::from_fn(|_| plane()),
            light: [plane(), plane()],
            contrast: vec![1.0; grid.plane_len()],
            energy: plane(),
            mean_energy: plane(),
            remaining_error: plane(),
            visible_part: VisiblePart::new(grid),
            visible: vec![1.0; grid.plane_len()],
            partial: Vec::with_capacity(grid.nodes()),
            is_inside: vec![true; grid.plane_len()],
            trust: vec![1.0; grid.plane_len()],
            weight: vec![1.0; grid.plane_len()],
            increment: NodeField::zero(grid),
        }
    }

    /// Factor on the normal equations: one over the noise variance and the overlap of the patches.
    pub(super) fn scale(&self, template: &Template) -> f32 {
        1.0 / (template.noise.variance() * self.window.overlap())
    }

    /// Computes what follows from the normal equations of a template and from the noise of both pictures.
    pub(crate) fn complete(&self, template: &mut Template, noise: Noise) {
        template.noise = noise;
        let scale = self.scale(template);
        let slope_stiffness = self.coupling.stiffness().curvature;
        for node in 0..self.grid.nodes() {
            let noise = noise_gradient(template.samples[node], noise.pixels.powi(2));
            let normal = |entry: usize| template.normal[entry][node];
            template.own_variance[node] = own_variance(normal, noise, scale, slope_stiffness);
            template.signal[node] = signal(normal, noise);
        }
        self.coupling.set_coarse_blocks(&template.normal, scale, &mut template.coarse);
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
        self.complete(&mut out.template, sharp.noise);
    }

    /// One Gauss–Newton step from `field`.
    pub(crate) fn step<const CHANNELS: usize>(
        &mut self,
        template: &Template,
        current: Current<'_, CHANNELS>,
        field: &mut NodeField,
        iterations: usize,
    ) {
        self.solve(template, current, field, iterations);
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
    pub(crate) fn is_worse_at<const CHANNELS: usize>(
        &mut self,
        template: &Template,
        current: Current<'_, CHANNELS>,
        field: &NodeField,
        other: &NodeField,
    ) -> impl Fn(usize) -> bool {
        for field in [other, field] {
            std::mem::swap(&mut self.energy, &mut self.mean_energy);
            self.expander.prepare(field);
            self.measure(template, current, field);
        }
        |node| self.energy[node] > CLEARLY_WORSE * self.mean_energy[node]
    }

    /// Measures the residual at `field` without changing it. The step that the patches would take counts as its error.
    pub(crate) fn inspect<const CHANNELS: usize>(
        &mut self,
        template: &Template,
        current: Current<'_, CHANNELS>,
        field: &NodeField,
        iterations: usize,
    ) {
        self.trust_all();
        self.solve(template, current, field, iterations);
        self.set_remaining_error(SEARCH_ERROR);
        for plane in &mut self.increment.planes {
            plane.fill(0.0);
        }
    }

    /// Writes the increment of a step from `field`.
    fn solve<const CHANNELS: usize>(
        &mut self,
        template: &Template,
        current: Current<'_, CHANNELS>,
        field: &NodeField,
        iterations: usize,
    ) {
        self.expander.prepare(field);
        self.measure(template, current, field);
        let level = self.level;
        dispatch!(level, simd => self.solve_simd(simd, template, field, iterations));
    }

    #[inline(always)]
    fn solve_simd<S: Simd>(&mut self, simd: S, template: &Template, field: &NodeField, iterations: usize) {
        self.form_right(template);
        for (weight, (trust, signal)) in self.weight.iter_mut().zip(self.trust.iter().zip(&template.signal)) {
            *weight = trust * signal;
        }
        let system = System {
            normal: &template.normal,
            coarse: &template.coarse,
            scale: self.scale(template),
            trust: &self.weight,
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

    /// Sums the products of residual and template over every patch at a field for which the expander is prepared.
    fn measure<const CHANNELS: usize>(
        &mut self,
        template: &Template,
        current: Current<'_, CHANNELS>,
        field: &NodeField,
    ) {
        let Self { level, team, window, expander, strips, gradient, light, energy, .. } = self;
        let measurement = Measurement { window, expander, template, current, field };
        let sums = Sums {
            gradient: gradient.each_mut().map(Vec::as_mut_slice),
            light: light.each_mut().map(Vec::as_mut_slice),
            energy,
        };
        measurement.run(*level, team, strips, sums);
        self.complete_sums(field);
    }

    /// Extrapolates the sums of patches that lie partly outside the current image to the whole patch.
    fn complete_sums(&mut self, field: &NodeField) {
        self.visible_part.write(self.grid, field, &mut self.visible, &mut self.partial);
        for &node in &self.partial {
            let factor = 1.0 / self.visible[node].max(LEAST_VISIBLE);
            for plane in self.gradient.iter_mut().chain(&mut self.light).chain([&mut self.energy]) {
                plane[node] *= factor;
            }
        }
    }

    /// Eliminates the change of light from the gradient sums and scales them by the noise.
    ///
    /// If a patch has γ times the contrast of the template, `I(x + u) = γ T(x − δ)`, its sums give the step `γ δ`. So
    /// they are divided by γ, which is the regression coefficient of the picture on the template. If the position of a
    /// patch is wrong by δ, γ is the autocorrelation of the texture at δ, and the division corrects the step for the
    /// curvature of the texture.
    fn form_right(&mut self, template: &Template) {
        let scale = self.scale(template);
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
        self.expander.prepare(field);
        let Self { grid, level, team, expander, strips, .. } = self;
        let PatchGrid { width, height, .. } = *grid;
        let middle = height / 2;
        let (upper_u, lower_u) = flow.u.values_mut().split_at_mut(middle * width);
        let (upper_v, lower_v) = flow.v.values_mut().split_at_mut(middle * width);
        let [upper, lower] = strips;
        team.join(
            || upper.expand(*level, (expander, field), 0..middle, [upper_u, upper_v]),
            || lower.expand(*level, (expander, field), middle..height, [lower_u, lower_v]),
        );
    }

    /// Sets the threads that share the work.
    pub(crate) fn set_team(&mut self, team: &Team) {
        self.team = team.clone();
    }
}

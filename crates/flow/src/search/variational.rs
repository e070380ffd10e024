//! Variational refinement of a dense field: brightness and gradient constancy with a robust smoothness term.
//!
//! Minimises over the increment `w = (du, dv)`, [Brox2004] in the normalised form of [Kroeger2016] §3.2:
//!
//! ```text
//! Σ  δ ψ(n₀ (∇I·w + I_t)²)  +  γ ψ(n_x (∇I_x·w + I_xt)² + n_y (∇I_y·w + I_yt)²)  +  α ψ(|∇(u + du)|² + |∇(v + dv)|²)
//! ```
//!
//! with `ψ(s) = √(s + ε²)`, `n = 1/(|∇|² + ζ²)`, `I_t` the current image warped back minus the reference. The robust
//! weights are fixed while successive over-relaxation solves the linear system, and updated in every outer pass.

use super::differences::differentiate;
use crate::FlowField;
use fingervision_image::{Between, Image};
use serde::{Deserialize, Serialize};

/// Parameters of the variational refinement.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RefineParams {
    /// Passes that update the robust weights; 0 switches the refinement off.
    pub passes: usize,
    /// Over-relaxation sweeps in each pass.
    pub sweeps: usize,
    /// Weight `α` of the smoothness, dimensionless.
    pub smoothness_weight: f32,
    /// Weight `δ` of brightness constancy, dimensionless.
    pub brightness_weight: f32,
    /// Weight `γ` of gradient constancy, dimensionless.
    pub gradient_weight: f32,
}

impl Default for RefineParams {
    fn default() -> Self {
        Self { passes: 5, sweeps: 5, smoothness_weight: 20.0, brightness_weight: 5.0, gradient_weight: 10.0 }
    }
}

/// Over-relaxation factor, dimensionless.
const RELAXATION: f32 = 1.6;
/// `ε²` of the robust function, dimensionless.
const ROBUST_FLOOR: f32 = 1e-6;
/// `ζ²` of the normalisation, grey levels² per px².
const GRADIENT_FLOOR: f32 = 0.01;

/// Scratch memory of the refinement: 18 planes.
#[derive(Debug, Clone)]
pub(crate) struct VariationalRefinement {
    warped: Image<f32>,
    /// Mean of reference and warped current image.
    mean: Image<f32>,
    /// First derivatives of `mean`, and of the temporal difference.
    first: [Image<f32>; 2],
    temporal: Image<f32>,
    temporal_first: [Image<f32>; 2],
    /// `∂xx`, `∂xy`, `∂yx`, `∂yy` of `mean`.
    second: [Image<f32>; 4],
    /// Entries 11, 12, 22 of the data matrix and both of the right-hand side.
    matrix: [Image<f32>; 3],
    right: [Image<f32>; 2],
    smoothness: Image<f32>,
    increment: [Image<f32>; 2],
}

impl VariationalRefinement {
    /// For fields of up to this size.
    pub(crate) fn new(width: usize, height: usize) -> Self {
        let plane = || Image::filled(width, height, 0.0);
        Self {
            warped: plane(),
            mean: plane(),
            first: [plane(), plane()],
            temporal: plane(),
            temporal_first: [plane(), plane()],
            second: [plane(), plane(), plane(), plane()],
            matrix: [plane(), plane(), plane()],
            right: [plane(), plane()],
            smoothness: plane(),
            increment: [plane(), plane()],
        }
    }

    /// Refines `flow` from `reference` to `current`, all of one size.
    pub(crate) fn refine(
        &mut self,
        params: &RefineParams,
        reference: &Image<f32>,
        current: &Image<f32>,
        flow: &mut FlowField,
    ) {
        if params.passes == 0 {
            return;
        }
        self.set_size(flow.u.size());
        self.linearise(reference, current, flow);
        for plane in &mut self.increment {
            plane.values_mut().fill(0.0);
        }
        for _ in 0..params.passes {
            self.weigh_data(params);
            self.weigh_smoothness(params, flow);
            for _ in 0..params.sweeps {
                self.sweep(flow);
            }
        }
        let [du, dv] = &self.increment;
        for (plane, increment) in [(&mut flow.u, du), (&mut flow.v, dv)] {
            for (value, increment) in plane.values_mut().iter_mut().zip(increment.values()) {
                *value += increment;
            }
        }
    }

    fn set_size(&mut self, size: (usize, usize)) {
        let Self { warped, mean, first, temporal, temporal_first, second, matrix, right, smoothness, increment } = self;
        let single = [warped, mean, temporal, smoothness].into_iter();
        let pairs = first.iter_mut().chain(temporal_first).chain(right).chain(increment);
        for plane in single.chain(pairs).chain(second).chain(matrix) {
            plane.set_size(size);
        }
    }

    fn linearise(&mut self, reference: &Image<f32>, current: &Image<f32>, flow: &FlowField) {
        warp_back(current, flow, &mut self.warped);
        let pairs = self.warped.values().iter().zip(reference.values());
        let targets = self.mean.values_mut().iter_mut().zip(self.temporal.values_mut());
        for ((mean, temporal), (warped, reference)) in targets.zip(pairs) {
            *mean = 0.5 * (warped + reference);
            *temporal = warped - reference;
        }
        let [x, y] = &mut self.first;
        differentiate(&self.mean, x, y);
        let [xx, xy, yx, yy] = &mut self.second;
        differentiate(x, xx, xy);
        differentiate(y, yx, yy);
        let [x, y] = &mut self.temporal_first;
        differentiate(&self.temporal, x, y);
    }

    fn weigh_data(&mut self, params: &RefineParams) {
        let [m11, m12, m22] = &mut self.matrix;
        let [b1, b2] = &mut self.right;
        for i in 0..self.temporal.values().len() {
            let at = |image: &Image<f32>| image.values()[i];
            let (du, dv) = (at(&self.increment[0]), at(&self.increment[1]));
            let brightness = Constraint::new(at(&self.first[0]), at(&self.first[1]), at(&self.temporal));
            let along_x = Constraint::new(at(&self.second[0]), at(&self.second[1]), at(&self.temporal_first[0]));
            let along_y = Constraint::new(at(&self.second[2]), at(&self.second[3]), at(&self.temporal_first[1]));
            let brightness_weight = params.brightness_weight * robust_slope(brightness.error(du, dv));
            let gradient_weight = params.gradient_weight * robust_slope(along_x.error(du, dv) + along_y.error(du, dv));
            let mut sums = [0.0; 5];
            for (constraint, weight) in
                [(brightness, brightness_weight), (along_x, gradient_weight), (along_y, gradient_weight)]
            {
                for (sum, term) in sums.iter_mut().zip(constraint.normal_equations()) {
                    *sum += weight * term;
                }
            }
            for (plane, sum) in [&mut *m11, &mut *m12, &mut *m22, &mut *b1, &mut *b2].into_iter().zip(sums) {
                plane.values_mut()[i] = sum;
            }
        }
    }

    /// Diffusivity `α ψ′` at every pixel, from forward differences.
    fn weigh_smoothness(&mut self, params: &RefineParams, flow: &FlowField) {
        let (width, height) = self.smoothness.size();
        let [du, dv] = &self.increment;
        for y in 0..height {
            let below = (y + 1).min(height - 1);
            for x in 0..width {
                let right = (x + 1).min(width - 1);
                let mut roughness = 0.0;
                for (plane, increment) in [(&flow.u, du), (&flow.v, dv)] {
                    let at = |x: usize, y: usize| plane.at(x, y) + increment.at(x, y);
                    let here = at(x, y);
                    roughness += (at(right, y) - here).powi(2) + (at(x, below) - here).powi(2);
                }
                self.smoothness.row_mut(y)[x] = params.smoothness_weight * robust_slope(roughness);
            }
        }
    }

    /// One sweep of successive over-relaxation in reading order.
    fn sweep(&mut self, flow: &FlowField) {
        let (width, height) = self.smoothness.size();
        for y in 0..height {
            for x in 0..width {
                let weight_here = self.smoothness.at(x, y);
                // A forward difference belongs to the pixel it starts from.
                let neighbours = [
                    (x + 1 < width).then(|| (x + 1, y, weight_here)),
                    (y + 1 < height).then(|| (x, y + 1, weight_here)),
                    (x > 0).then(|| (x - 1, y, self.smoothness.at(x - 1, y))),
                    (y > 0).then(|| (x, y - 1, self.smoothness.at(x, y - 1))),
                ];
                let (mut total, mut pull) = (1e-6, [0.0; 2]);
                for (nx, ny, weight) in neighbours.into_iter().flatten() {
                    total += weight;
                    for (pull, (plane, increment)) in
                        pull.iter_mut().zip([(&flow.u, &self.increment[0]), (&flow.v, &self.increment[1])])
                    {
                        *pull += weight * (plane.at(nx, ny) + increment.at(nx, ny) - plane.at(x, y));
                    }
                }
                let [m11, m12, m22] = [0, 1, 2].map(|k| self.matrix[k].at(x, y));
                let [b1, b2] = [0, 1].map(|k| self.right[k].at(x, y));
                let [du, dv] = [0, 1].map(|k| self.increment[k].at(x, y));
                let du = du + RELAXATION * ((b1 + pull[0] - m12 * dv) / (m11 + total) - du);
                let dv = dv + RELAXATION * ((b2 + pull[1] - m12 * du) / (m22 + total) - dv);
                self.increment[0].row_mut(y)[x] = du;
                self.increment[1].row_mut(y)[x] = dv;
            }
        }
    }
}

/// One linear constraint `gx du + gy dv + t = 0`, normalised by its gradient.
#[derive(Debug, Clone, Copy)]
struct Constraint {
    gx: f32,
    gy: f32,
    t: f32,
    norm: f32,
}

impl Constraint {
    fn new(gx: f32, gy: f32, t: f32) -> Self {
        Self { gx, gy, t, norm: 1.0 / (gx * gx + gy * gy + GRADIENT_FLOOR) }
    }

    fn error(&self, du: f32, dv: f32) -> f32 {
        self.norm * (self.gx * du + self.gy * dv + self.t).powi(2)
    }

    fn normal_equations(&self) -> [f32; 5] {
        let Self { gx, gy, t, norm } = *self;
        [norm * gx * gx, norm * gx * gy, norm * gy * gy, -norm * gx * t, -norm * gy * t]
    }
}

/// `ψ′(s) = 1/(2√(s + ε²))`, up to the factor ½ that all terms share.
fn robust_slope(s: f32) -> f32 {
    1.0 / (s + ROBUST_FLOOR).sqrt()
}

/// Writes `current(x + flow(x))` by bilinear sampling, clamped to the border.
pub(crate) fn warp_back(current: &Image<f32>, flow: &FlowField, warped: &mut Image<f32>) {
    for y in 0..current.height() {
        let displacements = flow.u.row(y).iter().zip(flow.v.row(y));
        for (x, (warped, (u, v))) in warped.row_mut(y).iter_mut().zip(displacements).enumerate() {
            *warped = Between::clamped((x as f32 + u, y as f32 + v), current.size()).sample(current);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refinement_reduces_the_errors_of_a_rough_field() {
        let (width, height) = (48, 40);
        let wave = |dx: f32| {
            Image::from_fn(width, height, |x, y| {
                let (x, y) = (x as f32 - dx, y as f32);
                128.0 + 50.0 * (0.4 * x).sin() + 40.0 * (0.35 * y + 0.1 * x).cos()
            })
        };
        let (reference, current) = (wave(0.0), wave(0.7));
        // Alternating errors of 0.2 px, as blocks of failed patches cause them.
        let error = |x: usize, y: usize| if (x / 4 + y / 4).is_multiple_of(2) { 0.2 } else { -0.2 };
        let mut flow = FlowField {
            u: Image::from_fn(width, height, |x, y| 0.7 + error(x, y)),
            v: Image::from_fn(width, height, error),
        };
        let mut refinement = VariationalRefinement::new(width, height);
        refinement.refine(&RefineParams::default(), &reference, &current, &mut flow);
        let mean = |plane: &Image<f32>, truth: f32| {
            plane.values().iter().map(|value| (value - truth).abs()).sum::<f32>() / (width * height) as f32
        };
        let (u, v) = (mean(&flow.u, 0.7), mean(&flow.v, 0.0));
        assert!(u < 0.05 && v < 0.05, "mean errors {u} and {v} after, 0.2 before");
    }
}

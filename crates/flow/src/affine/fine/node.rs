//! The equations of a fine patch.

use super::cell::RESIDUALS;
use crate::ValidityParams;
use crate::affine::judge::{LEAST_CONTRAST, blur_error};
use crate::affine::nodes::UNKNOWNS;
use crate::affine::noise::Noise;
use crate::affine::refinement::CONTRASTS;
use crate::affine::symmetric::{PACKED, packed};
use crate::affine::template::PatchEquations;

/// Least pivot of a node's block, per px².
const LEAST_PIVOT: f32 = 1e-3;

/// The six unknowns of a node.
pub(super) type Motion = [f32; UNKNOWNS];

/// A fine patch: its sums and its step, and the results of the last step.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct FineNode {
    /// Its index in the grid.
    pub(super) place: usize,
    /// The motion from which it is matched: that of the coarse field, or one taken from a patch around it.
    pub(super) start: Motion,
    /// Sums over the residual, as in [`super::cell::residuals`].
    pub(super) sums: [f32; RESIDUALS],
    /// Right-hand side, in units of the noise.
    pub(super) right: Motion,
    pub(super) contrast: f32,
    /// The step that is being solved for.
    pub(super) step: Motion,
    pub(super) is_trusted: bool,
    /// Residual per sample, grey levels².
    pub(super) mean_energy: f32,
    /// Square of the error of the coarse patch that blur causes, px².
    pub(super) coarse_blur_error: f32,
    /// Mean roughness of the field around the node, relative to what the prior expects.
    pub(super) roughness: f32,
}

impl FineNode {
    /// The node with this index in the grid.
    pub(super) fn at(place: usize, coarse_blur_error: f32) -> Self {
        Self { place, coarse_blur_error, is_trusted: true, ..Self::default() }
    }

    /// Forms the right-hand side as for the coarse patches: eliminates the change of light and divides by the contrast.
    pub(super) fn form_right(&mut self, equations: &PatchEquations, scale: f32) {
        let [gain, offset] = [self.sums[UNKNOWNS], self.sums[UNKNOWNS + 1]];
        self.contrast = self.measured_contrast(equations);
        let contrast = self.contrast.clamp(CONTRASTS.0, CONTRASTS.1);
        for ((right, sum), by_light) in self.right.iter_mut().zip(&self.sums).zip(&equations.light_gain) {
            *right = scale * (sum - by_light[0] * gain - by_light[1] * offset) / contrast;
        }
    }

    /// The contrast of the picture relative to the template's.
    fn measured_contrast(&self, equations: &PatchEquations) -> f32 {
        let [d00, d01, _] = equations.light_inverse;
        1.0 - (d00 * self.sums[UNKNOWNS] + d01 * self.sums[UNKNOWNS + 1])
    }

    /// The energy of the residual that no change of light explains.
    fn energy_beside_light(&self, equations: &PatchEquations) -> f32 {
        let [d00, d01, d11] = equations.light_inverse;
        let [gain, offset, energy] = [0, 1, 2].map(|k| self.sums[UNKNOWNS + k]);
        energy - (d00 * gain * gain + 2.0 * d01 * gain * offset + d11 * offset * offset)
    }

    /// Decides from the residual after its step whether the patch failed.
    pub(super) fn judge(&mut self, equations: &PatchEquations, scale: f32, noise: Noise, rules: &ValidityParams) {
        let PatchEquations { normal, samples, variance, .. } = equations;
        let mut left = self.energy_beside_light(equations) / self.contrast.max(LEAST_CONTRAST).powi(2);
        for ((step, image), right) in self.step.iter().zip(multiply(normal, &self.step)).zip(&self.right) {
            left += step * (image - 2.0 / scale * right);
        }
        let left = left.max(0.0);
        let is_explained = left <= allowed(*variance, noise, rules) * samples;
        self.is_trusted = is_explained && self.contrast >= LEAST_CONTRAST;
        self.mean_energy = left / samples.max(1.0);
    }

    /// The residual without a step, relative to the largest of a valid patch; infinite if the contrast is too low.
    pub(super) fn unexplained(&self, equations: &PatchEquations, noise: Noise, rules: &ValidityParams) -> f32 {
        let contrast = self.measured_contrast(equations);
        if contrast < LEAST_CONTRAST {
            return f32::INFINITY;
        }
        let left = self.energy_beside_light(equations).max(0.0) / contrast.powi(2);
        left / (allowed(equations.variance, noise, rules) * equations.samples.max(1.0))
    }

    /// Square of the error that blur causes, px²; `variance` is that of the template. `likelihood` is that of blur; the coarse
    /// patch's error contains it.
    pub(super) fn blur_error(&self, variance: f32, noise_variance: f32, likelihood: f32) -> f32 {
        let own = blur_error(self.contrast, self.mean_energy - noise_variance, variance.max(noise_variance));
        (likelihood * own).max(self.coarse_blur_error)
    }
}

/// The largest residual per sample of a valid patch, grey levels², from the variance of its template.
fn allowed(variance: f32, noise: Noise, rules: &ValidityParams) -> f32 {
    (rules.noise_floor.powi(2) * noise.residual_variance()).max(rules.max_unexplained * variance)
}

/// `M x` with a packed symmetric matrix.
#[inline]
fn multiply(matrix: &[f32; PACKED], x: &Motion) -> Motion {
    let mut image = [0.0; UNKNOWNS];
    for (i, image) in image.iter_mut().enumerate() {
        for (j, x) in x.iter().enumerate() {
            *image += matrix[packed(i, j)] * x;
        }
    }
    image
}

/// Factors a symmetric positive definite packed matrix into `L D Lᵀ`: `L` below the diagonal, `1/D` on it.
pub(super) fn factor(mut matrix: [f32; PACKED]) -> [f32; PACKED] {
    for i in 0..UNKNOWNS {
        // Not yet divided by D: done at the end of the row.
        for j in 0..i {
            for k in 0..j {
                matrix[packed(i, j)] -= matrix[packed(i, k)] * matrix[packed(j, k)];
            }
        }
        for j in 0..i {
            let scaled = matrix[packed(i, j)] * matrix[packed(j, j)];
            matrix[packed(i, i)] -= matrix[packed(i, j)] * scaled;
            matrix[packed(i, j)] = scaled;
        }
        matrix[packed(i, i)] = 1.0 / matrix[packed(i, i)].max(LEAST_PIVOT);
    }
    matrix
}

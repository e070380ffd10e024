//! Validity and uncertainty: which patches failed, and the deviation of the flow at every pixel.
//!
//! A patch's own uncertainty is that of its displacement when its slopes are known to the accuracy of the prior and the
//! change of light is unknown: the trace of the inverse normal matrix times the noise variance, a Cramér–Rao bound
//! ([Kay1993] §3). Where a patch has little texture, its neighbours determine it through the coupling, and its deviation
//! grows with the distance to them. Both are scaled by the residual where that exceeds the noise, and grow where the
//! field is rougher than patches can represent.

use super::grid::{PatchGrid, STRIDE};
use super::nodes::{NodeField, UNKNOWNS};
use super::refinement::Refinement;
use super::symmetric::packed;
use super::template::Template;
use crate::{Estimate, ValidityParams};
use fearless_simd::Simd;
use fearless_simd_macros::simd;

/// Systematic error that averaging does not remove, px²: sampling and interpolation, measured on noise-free images.
pub(super) const FLOOR_VARIANCE: f32 = 0.003 * 0.003;

/// Part of the roughness between neighbours, squared, that becomes a patch's own error: measured on simulated presses.
const ROUGH_PATCH: f32 = 0.06;
/// The same for a patch that is determined by its neighbours only.
const ROUGH_STEP: f32 = 0.2;

/// A patch that a step moves by less has converged, px.
const SETTLED_PX: f32 = 0.1;
/// Least part of the template's contrast in a patch: with less, the picture does not show the template.
pub(super) const LEAST_CONTRAST: f32 = 0.4;

/// Lowers each node's variance to that of a neighbour plus the cost of the distance from it: two passes over the grid.
pub(crate) fn spread_variance(grid: PatchGrid, steps: &[f32], variance: &mut [f32]) {
    let columns = grid.columns;
    let mut lower = |node: usize, from: Option<usize>| {
        if let Some(from) = from {
            variance[node] = variance[node].min(variance[from] + steps[node]);
        }
    };
    let nodes = grid.nodes();
    for node in 0..nodes {
        lower(node, (node % columns > 0).then(|| node - 1));
        lower(node, node.checked_sub(columns));
    }
    for node in (0..nodes).rev() {
        lower(node, ((node + 1) % columns > 0).then_some(node + 1));
        lower(node, (node + columns < nodes).then_some(node + columns));
    }
}

impl Refinement {
    /// Turns the measured energy into the residual energy after the step and the change of light, at the template's
    /// contrast: `(Σ r² − l·D⁻¹l) / γ² − 2 b·δ + δ·Aδ` with `b` over γ already, exact for the linear model.
    fn predict_energy(&mut self, template: &Template) {
        let unscale = 1.0 / self.scale();
        let [gain, offset] = &self.light;
        let [d00, d01, d11] = &template.light_inverse;
        let delta = &self.increment.planes;
        for (n, energy) in self.energy.iter_mut().enumerate() {
            let (l0, l1) = (gain[n], offset[n]);
            let by_light = d00[n] * l0 * l0 + 2.0 * d01[n] * l0 * l1 + d11[n] * l1 * l1;
            let mut left = (*energy - by_light) / self.contrast[n].max(LEAST_CONTRAST).powi(2);
            for i in 0..UNKNOWNS {
                let mut image = 0.0;
                for (j, delta) in delta.iter().enumerate() {
                    image += template.normal[packed(i, j)][n] * delta[n];
                }
                left += delta[i][n] * (image - 2.0 * unscale * self.gradient[i][n]);
            }
            *energy = left.max(0.0);
        }
    }

    /// Forgets which patches failed.
    pub(crate) fn trust_all(&mut self) {
        self.trust.fill(1.0);
    }

    /// Whether the last step still moved more than a hundredth of the valid patches by more than [`SETTLED_PX`].
    pub(crate) fn is_moving(&self) -> bool {
        let [u, _, _, v, ..] = &self.increment.planes;
        let nodes = u.iter().zip(v).zip(&self.trust).take(self.grid.nodes());
        let moving = nodes.filter(|((u, v), trust)| **trust > 0.0 && *u * *u + *v * *v > SETTLED_PX * SETTLED_PX);
        100 * moving.count() > self.grid.nodes()
    }

    /// 1 for every valid patch, 0 where it failed.
    pub(crate) fn trust(&self) -> &[f32] {
        &self.trust
    }

    /// Decides which patches failed: those whose residual the noise does not explain, nor the template's own contrast,
    /// and those whose centre has left the image.
    pub(crate) fn judge(&mut self, template: &Template, field: &NodeField, rules: &ValidityParams) {
        self.predict_energy(template);
        let floor = rules.noise_floor.powi(2) * self.noise_variance;
        for node in 0..self.grid.nodes() {
            let allowed = floor.max(rules.max_unexplained * template.variance[node]);
            let is_explained =
                self.energy[node] <= allowed * template.samples[node] && self.contrast[node] >= LEAST_CONTRAST;
            self.is_inside[node] = field.is_inside(node);
            self.trust[node] = f32::from(u8::from(is_explained && self.is_inside[node]));
            self.mean_energy[node] = self.energy[node] / template.samples[node].max(1.0);
        }
    }

    /// The patches' own variance, scaled by the residual where that exceeds the noise; infinite for failed patches. Added
    /// is the error of a patch where the field is rough. `steps` takes the cost of the distance between neighbouring
    /// nodes, given that cost in a smooth field.
    pub(crate) fn scale_variance(&self, own: &[f32], smooth_step: f32, variance: &mut [f32], steps: &mut [f32]) {
        for node in 0..self.grid.nodes() {
            let rough = self.coupling.roughness(node) * smooth_step;
            let excess = (self.mean_energy[node] / self.noise_variance).max(1.0);
            steps[node] = smooth_step + ROUGH_STEP * rough;
            let known = own[node] * excess + ROUGH_PATCH * rough;
            variance[node] = if self.trust[node] > 0.0 { known } else { f32::MAX };
        }
    }

    /// Adds the correction that is still missing, which neighbours do not reduce.
    pub(crate) fn add_unfinished(&self, variance: &mut [f32]) {
        for (variance, unfinished) in variance.iter_mut().zip(&self.unfinished) {
            *variance += unfinished;
        }
    }

    /// How well the patches with a variance up to `textured` match; `ranks` is scratch memory.
    ///
    /// Patches that left the image do not count, unless they are the majority: then the flow has diverged.
    pub(crate) fn summarise(&self, template: &Template, textured: f32, ranks: &mut Vec<f32>) -> Match {
        let (mut all, mut inside, mut good, mut energy) = (0.0_f32, 0.0, 0.0, 0.0);
        ranks.clear();
        for (node, own) in template.own_variance[..self.grid.nodes()].iter().enumerate() {
            if *own <= textured {
                all += 1.0;
                inside += f32::from(u8::from(self.is_inside[node]));
                good += self.trust[node];
                energy += self.trust[node] * self.mean_energy[node];
                if self.is_inside[node] {
                    ranks.push(self.mean_energy[node] / template.variance[node]);
                }
            }
        }
        if good <= 0.0 {
            return Match { part: 0.0, residual_levels: f32::NAN, unexplained: 1.0 };
        }
        let middle = ranks.len() / 2;
        let unexplained = *ranks.select_nth_unstable_by(middle, f32::total_cmp).1;
        Match { part: good / inside.max(0.5 * all), residual_levels: (energy / good).sqrt(), unexplained }
    }
}

/// How well the textured patches of a picture match.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Match {
    /// The part of them that is valid, 0 to 1.
    pub(crate) part: f32,
    /// Their residual, root mean square, grey levels; not a number where there are none.
    pub(crate) residual_levels: f32,
    /// The median over all patches of the unexplained part of the variance, 0 to 1.
    pub(crate) unexplained: f32,
}

/// Writes deviation and validity of every pixel of an estimate whose flow is known.
///
/// A pixel takes the values of the node it is nearest to, and is invalid where that patch failed or where it has left
/// the current image.
#[simd]
pub(crate) fn mark_pixels<S: Simd>(
    simd: S,
    grid: PatchGrid,
    variance: &[f32],
    trust: &[f32],
    max_deviation: f32,
    out: &mut Estimate,
) {
    let _ = simd;
    for y in 0..grid.height {
        let start = (y / STRIDE).min(grid.rows - 1) * grid.columns;
        let deviation = out.deviation.row_mut(y);
        for (i, cell) in deviation.chunks_mut(STRIDE).enumerate() {
            let node = start + i;
            let of_node = (variance[node] + FLOOR_VARIANCE).sqrt();
            cell.fill(if trust[node] > 0.0 { of_node } else { f32::INFINITY });
        }
        let size = (grid.width as f32 - 1.0, grid.height as f32 - 1.0);
        hide_outside((out.flow.u.row(y), out.flow.v.row(y)), y as f32, size, deviation);
        for (valid, deviation) in out.valid.row_mut(y).iter_mut().zip(out.deviation.row(y)) {
            *valid = u8::from(*deviation <= max_deviation);
        }
    }
}

/// Makes the deviation infinite where a row's points have left an image with the given last column and row.
#[inline(always)]
#[expect(clippy::needless_bitwise_bool, reason = "without branches the loop is vectorised")]
fn hide_outside((u, v): (&[f32], &[f32]), y: f32, (right, bottom): (f32, f32), deviation: &mut [f32]) {
    let n = deviation.len();
    let (u, v) = (&u[..n], &v[..n]);
    for x in 0..n {
        let (px, py) = (x as f32 + u[x], y + v[x]);
        let is_inside = (px >= 0.0) & (py >= 0.0) & (px <= right) & (py <= bottom);
        deviation[x] = if is_inside { deviation[x] } else { f32::INFINITY };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variance_grows_with_the_way_to_the_next_texture() {
        let grid = PatchGrid::over(40, 24);
        let mut variance = vec![f32::MAX; grid.plane_len()];
        variance[6] = 1.0;
        spread_variance(grid, &vec![0.5; grid.plane_len()], &mut variance);
        let expected: Vec<f32> = (0..15)
            .map(|node| {
                let (dx, dy) = ((node % 5_i32 - 1).abs(), (node / 5 - 1).abs());
                1.0 + 0.5 * (dx + dy) as f32
            })
            .collect();
        assert_eq!(variance[..15], expected);
    }
}

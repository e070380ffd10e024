//! Validity and deviation: which patches failed, and the expected error of the flow at every pixel.
//!
//! A patch's own variance is that of its displacement from its own pixels. The prior limits its slopes; the change of
//! light is unknown. The variance follows from the inverse normal matrix and the noise variance: a Cramér–Rao bound
//! ([Kay1993] §3). A patch with little texture is determined by its neighbours, through the coupling; its variance
//! grows with the distance to them. The variance is increased where the residual exceeds the noise, and where the field
//! is rougher than patches can represent.

use super::grid::{LANES, PatchGrid, STRIDE};
use super::nodes::{NodeField, UNKNOWNS};
use super::refinement::Refinement;
use super::symmetric::packed;
use super::template::Template;
use super::visible::LEAST_VISIBLE;
use crate::{Estimate, ValidityParams};
use fearless_simd::{Simd, dispatch, f32x16, prelude::*};
use fearless_simd_macros::simd;

/// Systematic error that averaging does not remove, px²: sampling and interpolation, measured on noise-free images.
pub(super) const FLOOR_VARIANCE: f32 = 0.003 * 0.003;

/// Variance that a patch gets from rough flow, relative to the squared roughness; measured on simulated presses.
const ROUGH_PATCH: f32 = 0.06;
/// The same for a patch that only its neighbours determine.
const ROUGH_STEP: f32 = 0.2;

/// Increase of the variance from a node to one without texture that lies between two with texture, px²: the flow there is
/// interpolated. A patch beside texture may then be valid, the next one not.
const ENCLOSED_STEP: f32 = 0.2 * 0.2;
/// The same for a node at the edge of the pattern, where the flow is extrapolated. A patch without any texture is then not valid.
const EDGE_STEP: f32 = 0.3 * 0.3;
/// How many nodes away from a node without texture those with texture may lie, on both sides of it.
const ENCLOSED_NODES: usize = 2;

/// Error of a patch that lies partly outside the current image, px, relative to the part that is outside: the visible part has
/// another middle. Measured on patterns that turn by 20° and grow by 15 %.
const HIDDEN_PX: f32 = 0.5;

/// A patch has converged if its step is shorter than this, px.
const CONVERGED_PX: f32 = 0.1;
/// Error of a patch whose picture is blurred, px, relative to its loss of contrast times the part of the template's variance
/// that it leaves unexplained. Light changes the one, a rim the other; blur changes both. Measured on simulated presses
/// that move by 2 to 12 px while the shutter is open: the error is that of the mean position in this time.
const BLUR_ERROR_PX: f32 = 12.0;

/// Least contrast of a patch relative to the template's. With less, the picture does not show the template there.
pub(super) const LEAST_CONTRAST: f32 = 0.4;

/// Limits the variance of each node to that of a neighbour plus `steps`, the increase from node to node. Makes two
/// passes over the grid.
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

/// Whether nodes that are known lie on both sides of a node, in its row or in its column, at most [`ENCLOSED_NODES`] away.
fn is_enclosed(grid: PatchGrid, node: usize, is_known: impl Fn(usize) -> bool) -> bool {
    let (column, row) = (node % grid.columns, node / grid.columns);
    let lies_between = |place: usize, count: usize, stride: usize| {
        let before = (1..=ENCLOSED_NODES.min(place)).any(|k| is_known(node - k * stride));
        let after = (1..=ENCLOSED_NODES.min(count - 1 - place)).any(|k| is_known(node + k * stride));
        before && after
    };
    lies_between(column, grid.columns, 1) || lies_between(row, grid.rows, grid.columns)
}

/// Square of the error of a patch whose picture is blurred, px², from its contrast relative to the template's, its residual's
/// variance above that of noise, and the template's variance, grey levels².
#[inline(always)]
pub(super) fn blur_error(contrast: f32, residual: f32, variance: f32) -> f32 {
    (BLUR_ERROR_PX * (1.0 - contrast).max(0.0) * residual.max(0.0) / variance).powi(2)
}

impl Refinement {
    /// Converts the measured energy to that of the residual after the step and the change of light, at the template's
    /// contrast: `(Σ r² − l·D⁻¹l) / γ² − 2 b·δ + δ·Aδ`, where `b` is already divided by γ. Exact for the linear model.
    #[simd]
    fn predict_energy<S: Simd>(&mut self, simd: S, template: &Template) {
        let unscale = 1.0 / self.scale(template);
        for start in (0..self.energy.len()).step_by(LANES) {
            let load = |plane: &[f32]| f32x16::from_slice(simd, &plane[start..][..LANES]);
            let [gain, offset] = self.light.each_ref().map(|plane| load(plane));
            let [d00, d01, d11] = template.light_inverse.each_ref().map(|plane| load(plane));
            let by_light = d00 * gain * gain + d01 * gain * offset * 2.0 + d11 * offset * offset;
            let contrast = load(&self.contrast).max(f32x16::splat(simd, LEAST_CONTRAST));
            let mut left = (load(&self.energy) - by_light) / (contrast * contrast);
            let delta = self.increment.planes.each_ref().map(|plane| load(plane));
            for i in 0..UNKNOWNS {
                let mut image = load(&self.gradient[i]) * (-2.0 * unscale);
                for (j, delta) in delta.iter().enumerate() {
                    image = load(&template.normal[packed(i, j)]).mul_add(*delta, image);
                }
                left = delta[i].mul_add(image, left);
            }
            left.max(f32x16::splat(simd, 0.0)).store_slice(&mut self.energy[start..][..LANES]);
        }
    }

    /// Marks all patches as valid.
    pub(crate) fn trust_all(&mut self) {
        self.trust.fill(1.0);
    }

    /// Whether the last step moved more than 1 % of the patches by more than [`CONVERGED_PX`]; failed ones are not
    /// counted.
    pub(crate) fn is_moving(&self) -> bool {
        let [u, _, _, v, ..] = &self.increment.planes;
        let nodes = u.iter().zip(v).zip(&self.trust).take(self.grid.nodes());
        let moving = nodes.filter(|((u, v), trust)| **trust > 0.0 && *u * *u + *v * *v > CONVERGED_PX * CONVERGED_PX);
        100 * moving.count() > self.grid.nodes()
    }

    /// 1 for every valid patch, 0 where it failed.
    pub(crate) fn trust(&self) -> &[f32] {
        &self.trust
    }

    /// Decides which patches failed: those whose residual is larger than the noise and the template's variance allow,
    /// those with too little contrast, and those whose centre is outside the image.
    pub(crate) fn judge(&mut self, template: &Template, field: &NodeField, rules: &ValidityParams) {
        let level = self.level;
        dispatch!(level, simd => self.predict_energy(simd, template));
        let floor = rules.noise_floor.powi(2) * template.noise.residual_variance();
        let n = self.grid.nodes();
        field.mark_inside(&mut self.is_inside[..n]);
        for &node in &self.partial {
            self.is_inside[node] &= self.visible[node] >= LEAST_VISIBLE;
        }
        let (variance, samples) = (&template.variance[..n], &template.samples[..n]);
        let (energy, contrast) = (&self.energy[..n], &self.contrast[..n]);
        let (is_inside, trust, mean) = (&self.is_inside[..n], &mut self.trust[..n], &mut self.mean_energy[..n]);
        for node in 0..n {
            let allowed = floor.max(rules.max_unexplained * variance[node]);
            let is_explained = energy[node] <= allowed * samples[node] && contrast[node] >= LEAST_CONTRAST;
            trust[node] = f32::from(u8::from(is_explained && is_inside[node]));
            mean[node] = energy[node] / samples[node].max(1.0);
        }
    }

    /// Square of the error of a patch that blur causes, px²; 0 if it failed.
    ///
    /// The noise is that of the coupling, which is proportional to the contrast: if it were that of the pixels, blur of a weak pattern would
    /// look like noise.
    pub(crate) fn blur_error(&self, template: &Template, node: usize) -> f32 {
        let (noise, variance) = (template.noise.variance(), template.variance[node]);
        self.trust[node] * blur_error(self.contrast[node], self.mean_energy[node] - noise, variance.max(noise))
    }

    /// Writes the variance of every patch: its own, scaled by the residual where that exceeds the noise, plus the part
    /// from rough flow; the largest number for failed patches. Writes to `steps` the increase of the variance from node
    /// to node; `smooth_step` is that in a smooth field. Patches with an own variance above `textured` have no texture.
    pub(crate) fn scale_variance(
        &self,
        (template, textured): (&Template, f32),
        smooth_step: f32,
        variance: &mut [f32],
        steps: &mut [f32],
    ) {
        let own = &template.own_variance;
        for node in 0..self.grid.nodes() {
            let rough = self.coupling.roughness(node) * smooth_step;
            let excess = (self.mean_energy[node] / template.noise.variance()).max(1.0);
            steps[node] = smooth_step + ROUGH_STEP * rough;
            if own[node] > textured {
                let lies_between = is_enclosed(self.grid, node, |node| own[node] <= textured && self.trust[node] > 0.0);
                let step = if lies_between { ENCLOSED_STEP } else { EDGE_STEP };
                steps[node] += step * (own[node] / textured - 1.0).min(1.0);
            }
            let known = own[node] * excess + ROUGH_PATCH * rough;
            variance[node] = if self.trust[node] > 0.0 { known } else { f32::MAX };
        }
    }

    /// Adds the error that further steps would correct, those of blur with its likelihood and of pixels outside the image, and
    /// another one. Neighbours do not reduce them.
    pub(crate) fn add_own_errors(
        &self,
        template: &Template,
        blur_likelihood: f32,
        other: impl Fn(usize) -> f32,
        variance: &mut [f32],
    ) {
        for (node, variance) in variance[..self.grid.nodes()].iter_mut().enumerate() {
            *variance += self.remaining_error[node] + blur_likelihood * self.blur_error(template, node) + other(node);
        }
        for &node in &self.partial {
            variance[node] += (HIDDEN_PX * (1.0 - self.visible[node])).powi(2);
        }
    }

    /// How well the patches with a variance up to `textured` match; `ranks` is scratch memory.
    ///
    /// Patches that left the image do not count, unless they are the majority: then the flow has diverged.
    pub(crate) fn summarise(&self, template: &Template, textured: f32, ranks: &mut Vec<f32>) -> MatchSummary {
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
            return MatchSummary { part: 0.0, residual_levels: f32::NAN, unexplained: 1.0 };
        }
        let middle = ranks.len() / 2;
        let unexplained = *ranks.select_nth_unstable_by(middle, f32::total_cmp).1;
        MatchSummary { part: good / inside.max(0.5 * all), residual_levels: (energy / good).sqrt(), unexplained }
    }
}

/// How well the textured patches of a picture match.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MatchSummary {
    /// The part of these patches that is valid, 0 to 1.
    pub(crate) part: f32,
    /// Root mean square residual of the valid ones, grey levels; NaN if there are none.
    pub(crate) residual_levels: f32,
    /// The residual's variance over the template's variance, 0 to 1: the median over these patches in the image.
    pub(crate) unexplained: f32,
}

/// Writes deviation and validity of every pixel of an estimate whose flow is known; `of_nodes` is scratch memory.
///
/// A pixel takes the values of the nearest node. It is not valid if that patch failed, or if the pixel has left the
/// current image.
#[simd]
pub(crate) fn mark_pixels<S: Simd>(
    simd: S,
    grid: PatchGrid,
    (variance, trust): (&[f32], &[f32]),
    max_deviation: f32,
    of_nodes: &mut [f32],
    out: &mut Estimate,
) {
    let _ = simd;
    for ((of_node, variance), trust) in of_nodes.iter_mut().zip(variance).zip(trust) {
        let deviation = (variance + FLOOR_VARIANCE).sqrt();
        *of_node = if *trust > 0.0 { deviation } else { f32::INFINITY };
    }
    for y in 0..grid.height {
        let start = (y / STRIDE).min(grid.rows - 1) * grid.columns;
        let of_nodes = &of_nodes[start..start + grid.columns];
        let deviation = out.deviation.row_mut(y);
        let (cells, rest) = deviation.as_chunks_mut::<STRIDE>();
        for (cell, &of_node) in cells.iter_mut().zip(of_nodes) {
            *cell = [of_node; STRIDE];
        }
        rest.fill(of_nodes[cells.len().min(grid.columns - 1)]);
        let size = (grid.width as f32 - 1.0, grid.height as f32 - 1.0);
        mark_outside((out.flow.u.row(y), out.flow.v.row(y)), y as f32, size, deviation);
        for (valid, deviation) in out.valid.row_mut(y).iter_mut().zip(out.deviation.row(y)) {
            *valid = u8::from(*deviation <= max_deviation);
        }
    }
}

/// Sets the deviation of a row's points to infinity where they have left the image, whose last column and row are
/// given.
#[inline(always)]
#[expect(clippy::needless_bitwise_bool, reason = "without branches the loop is vectorised")]
#[expect(clippy::cast_possible_wrap, reason = "the columns of an image")]
fn mark_outside((u, v): (&[f32], &[f32]), y: f32, (right, bottom): (f32, f32), deviation: &mut [f32]) {
    let n = deviation.len();
    let (u, v) = (&u[..n], &v[..n]);
    for x in 0..n {
        // Signed integers of 32 bits are converted in one instruction.
        let (px, py) = (x as i32 as f32 + u[x], y + v[x]);
        let is_inside = (px >= 0.0) & (py >= 0.0) & (px <= right) & (py <= bottom);
        deviation[x] = if is_inside { deviation[x] } else { f32::INFINITY };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variance_grows_with_the_distance_to_the_nearest_texture() {
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

    #[test]
    fn a_node_between_known_ones_in_its_row_or_column_is_enclosed() {
        let grid = PatchGrid::over(56, 40);
        let encloses = |known: &[usize], node| is_enclosed(grid, node, |node| known.contains(&node));
        assert!(encloses(&[15, 18], 17), "in a row");
        assert!(encloses(&[3, 24], 17), "in a column");
        assert!(!encloses(&[14, 18], 17), "too far away");
        assert!(!encloses(&[18, 24], 17), "only on one side of each");
        assert!(!encloses(&[18, 19], 20), "at the edge of the pattern");
        assert!(!encloses(&[12, 15], 14), "the row before is another row");
    }
}

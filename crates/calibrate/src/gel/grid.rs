//! The residual for gels with values around the fitted ones.

use fingervision_elastic::GelBlock;
use serde::Serialize;

use super::GelFitError;
use super::fit::unexplained_by;
use super::forward::{Explained, Models};
use super::look::Look;
use super::thresholds::THRESHOLDS;

/// Gels along each axis whose motion is computed; between them it is interpolated by a polynomial through all.
const NODES: usize = 3;
/// Gels along each axis of the grid.
const SIDE: usize = 31;
/// Least half width of the grid, in ν and ln thickness.
const LEAST: [f64; 2] = [0.05, 0.15];

/// The residual over Poisson's ratio and thickness.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ResidualGrid {
    /// Poisson's ratios, the columns.
    pub poissons_ratios: Vec<f64>,
    /// Thicknesses, mm, the rows.
    pub thicknesses_mm: Vec<f64>,
    /// Root mean square of the unexplained motion over the depth, row by row.
    pub unexplained: Vec<f64>,
}

impl ResidualGrid {
    /// The grid around a gel, three deviations to each side and at least the least half width.
    pub(super) fn about(
        gel: &GelBlock,
        looks: &[Look],
        models: &mut Models,
        covariance: &[[f64; 2]; 2],
    ) -> Result<Self, GelFitError> {
        let reach = |i: usize| (3.0 * covariance[i][i].sqrt()).clamp(LEAST[i], 2.0 * LEAST[i]);
        let (ratio, thickness) = (reach(0), reach(1));
        let [least, most] = THRESHOLDS.ratios;
        let middle = gel.poissons_ratio.clamp(least + ratio, most - ratio);
        let ratios = |count| (0..count).map(move |step| middle + ratio * part(step, count));
        let thicknesses = |count| (0..count).map(move |step| gel.thickness_mm * (thickness * part(step, count)).exp());
        let mut nodes = Vec::with_capacity(NODES * NODES);
        for thickness_mm in thicknesses(NODES) {
            for poissons_ratio in ratios(NODES) {
                nodes.push(models.explain(&GelBlock { poissons_ratio, thickness_mm, ..*gel }, looks)?);
            }
        }
        let weights: Vec<_> = (0..SIDE).map(|step| lagrange(1.0 + part(step, SIDE))).collect();
        let unexplained = weights.iter().flat_map(|down| {
            let nodes = &nodes;
            weights.iter().map(move |across| unexplained_by(looks, &between(nodes, *across, *down)))
        });
        Ok(Self {
            unexplained: unexplained.collect(),
            poissons_ratios: ratios(SIDE).collect(),
            thicknesses_mm: thicknesses(SIDE).collect(),
        })
    }
}

/// From −1 to 1 in this many steps.
fn part(step: usize, count: usize) -> f64 {
    2.0 * step as f64 / (count - 1) as f64 - 1.0
}

/// Weights of the nodes 0, 1 and 2 for the parabola through them, at a position.
fn lagrange(place: f64) -> [f64; NODES] {
    [0.5 * (place - 1.0) * (place - 2.0), place * (2.0 - place), 0.5 * place * (place - 1.0)]
}

/// The interpolated motion between the nodes.
fn between(nodes: &[Vec<Explained>], across: [f64; NODES], down: [f64; NODES]) -> Vec<Explained> {
    let weights: Vec<f64> = down.iter().flat_map(|down| across.map(|across| down * across)).collect();
    let frame = |frame: usize| {
        let cells = nodes[0][frame].apparent_mm.len();
        let mut apparent_mm = vec![[0.0; 2]; cells];
        for (node, weight) in nodes.iter().zip(&weights) {
            for (sum, made) in apparent_mm.iter_mut().zip(&node[frame].apparent_mm) {
                *sum = [sum[0] + weight * made[0], sum[1] + weight * made[1]];
            }
        }
        Explained { apparent_mm, force_per_modulus_mm2: 0.0 }
    };
    (0..nodes[0].len()).map(frame).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_between_nodes_are_those_of_a_parabola() {
        for place in [0.0, 0.3, 1.0, 1.7, 2.0] {
            let [a, b, c] = lagrange(place);
            assert!((a + b + c - 1.0).abs() < 1e-12, "at {place}");
            assert!((b + 4.0 * c - place * place).abs() < 1e-12, "at {place}");
        }
        for (step, wanted) in [(0, -1.0), (2, 0.0), (4, 1.0)] {
            assert!((part(step, 5) - wanted).abs() < 1e-12, "step {step}");
        }
    }
}

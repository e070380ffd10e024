//! What a patch's numbers are worth: which patches failed, and how uncertain the flow is at every pixel.
//!
//! A patch's own uncertainty is that of its displacement when its slopes are known as well as the prior knows them and
//! the change of light is unknown: the trace of the inverse normal matrix times the noise variance, a Cramér–Rao bound
//! ([Kay1993] §3). Where a patch has little texture its neighbours inform it through the coupling, and its deviation
//! grows with the way to them. Both are scaled by the residual that is left, where that exceeds the noise, and grow
//! where the field is rougher than patches can follow.

use super::grid::{PatchGrid, STRIDE};
use super::nodes::UNKNOWNS;
use super::template::{PACKED, packed};
use crate::Estimate;
use fearless_simd::Simd;
use fearless_simd_macros::simd;

/// Systematic error that no averaging removes, px²: sampling and interpolation, measured on noise-free images.
const FLOOR_VARIANCE: f32 = 0.003 * 0.003;

/// Variance of both components of every node's displacement from its own patch, px², for noise of the given scale.
pub(crate) fn own_variance(
    grid: PatchGrid,
    normal: &[Vec<f32>; PACKED],
    scale: f32,
    slope_stiffness: f32,
    variance: &mut [f32],
) {
    for node in 0..grid.nodes() {
        let mut block = [[0.0; UNKNOWNS]; UNKNOWNS];
        for (i, row) in block.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry = f64::from(scale * normal[packed(i, j)][node]);
            }
            row[i] += if i % 3 == 0 { 1e-9 } else { f64::from(slope_stiffness) };
        }
        let inverse = super::coupling::invert(block);
        let trace = inverse[0][0] + inverse[3][3];
        variance[node] = if trace.is_finite() && trace > 0.0 { trace as f32 } else { f32::MAX };
    }
}

/// Lowers each node's variance to what a neighbour knows and the way from it costs: two passes over the grid.
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

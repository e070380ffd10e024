//! The flow at the refined fine nodes and at their neighbours.

use super::cell::interpolate;
use super::grid::{CELL, CORNERS, CornerWeights, FineGrid, STRIDE, hermite_basis};
use super::node::{FineNode, Motion};
use crate::FlowField;
use crate::affine::grid::around;
use fearless_simd::Simd;
use fingervision_image::Image;

/// Distance in nodes up to which the cells of a refined node depend on other nodes: the twist at a corner is a
/// difference between the corner's neighbours.
const NEAR: usize = 2;

/// Largest difference between a patch and its start, in displacement, px, and in slopes, px per stride. Beyond
/// it, a patch would match by chance.
const MOST_CHANGE_PX: f32 = STRIDE as f32;

/// Displacement and slopes at the nodes near refined ones; between them the field is their bicubic Hermite interpolant.
#[derive(Debug, Clone)]
pub(super) struct FineField {
    grid: FineGrid,
    basis: Box<CornerWeights<4>>,
    /// For every node `(u, ∂u/∂x, ∂u/∂y, v, ∂v/∂x, ∂v/∂y)`, slopes in px per stride.
    motions: Vec<Motion>,
    /// Mixed second derivative of u and v, per stride².
    twists: Vec<[f32; 2]>,
    is_sampled: Vec<bool>,
}

impl FineField {
    pub(super) fn new(grid: FineGrid) -> Self {
        Self {
            grid,
            basis: Box::new(hermite_basis()),
            motions: vec![Motion::default(); grid.nodes()],
            twists: vec![[0.0; 2]; grid.nodes()],
            is_sampled: vec![false; grid.nodes()],
        }
    }

    /// The motion at every node near refined ones.
    pub(super) fn motions(&self) -> &[Motion] {
        &self.motions
    }

    /// Sets the field near refined nodes to values and slopes of a flow. The refined nodes start from these values.
    pub(super) fn sample(&mut self, flow: &FlowField, nodes: &mut [FineNode]) {
        let Self { grid, motions, is_sampled, .. } = self;
        is_sampled.fill(false);
        for node in nodes.iter() {
            for place in around((grid.columns, grid.rows), node.place, NEAR) {
                if std::mem::replace(&mut is_sampled[place], true) {
                    continue;
                }
                let (x, y) = (STRIDE * (place % grid.columns) + 1, STRIDE * (place / grid.columns) + 1);
                let ([u, ux, uy], [v, vx, vy]) = (sample(&flow.u, x, y), sample(&flow.v, x, y));
                motions[place] = [u, ux, uy, v, vx, vy];
            }
        }
        for node in nodes {
            node.start = motions[node.place];
        }
    }

    /// Sets another start for a node, from which it is matched again.
    pub(super) fn restart(&mut self, node: &mut FineNode, motion: Motion) {
        self.motions[node.place] = motion;
        (node.start, node.is_trusted) = (motion, true);
    }

    /// Adds the nodes' steps: `u ← u + (I + ∇u) δ`. A patch that would move too far from its start fails and returns to
    /// the start.
    pub(super) fn compose(&mut self, nodes: &mut [FineNode]) {
        for FineNode { place, start, step, is_trusted, .. } in nodes {
            let motion = &mut self.motions[*place];
            for first in [0, 3] {
                let (gx, gy) = (motion[first + 1] / STRIDE as f32, motion[first + 2] / STRIDE as f32);
                for k in 0..3 {
                    motion[first + k] += step[first + k] + gx * step[k] + gy * step[3 + k];
                }
            }
            let is_near = motion.iter().zip(&*start).all(|(value, start)| (value - start).abs() <= MOST_CHANGE_PX);
            if !is_near {
                (*motion, *is_trusted) = (*start, false);
            }
        }
    }

    /// Sets the twists at the corners of cells: call before [`FineField::flow`].
    pub(super) fn set_twists(&mut self, cells: &[usize]) {
        let Self { grid, motions, twists, .. } = self;
        let FineGrid { columns, rows, .. } = *grid;
        for &cell in cells {
            for place in grid.corners(cell) {
                let (i, j) = (place % columns, place / columns);
                let (left, right) = (place - usize::from(i > 0), place + usize::from(i + 1 < columns));
                let above = if j > 0 { place - columns } else { place };
                let below = if j + 1 < rows { place + columns } else { place };
                let (span_x, span_y) = ((right - left) as f32, ((below - above) / columns) as f32);
                for (twist, first) in twists[place].iter_mut().zip([0, 3]) {
                    let along_y = (motions[below][first + 1] - motions[above][first + 1]) / span_y;
                    let along_x = (motions[right][first + 2] - motions[left][first + 2]) / span_x;
                    *twist = 0.5 * (along_x + along_y);
                }
            }
        }
    }

    /// The displacement of a cell's pixels.
    #[inline(always)]
    pub(super) fn flow<S: Simd>(&self, simd: S, cell: usize) -> [[f32; CELL]; 2] {
        let mut flow = [[0.0; CELL]; 2];
        let mut values = [[0.0; 4]; CORNERS];
        for (component, flow) in flow.iter_mut().enumerate() {
            for (values, corner) in values.iter_mut().zip(self.grid.corners(cell)) {
                values[..3].copy_from_slice(&self.motions[corner][3 * component..][..3]);
                values[3] = self.twists[corner][component];
            }
            *flow = interpolate(simd, &self.basis, values);
        }
        flow
    }
}

/// Value half a pixel after `(x, y)` along both axes, and slopes per stride.
fn sample(plane: &Image<f32>, x: usize, y: usize) -> [f32; 3] {
    const HALF: usize = STRIDE / 2;
    let (width, height) = plane.size();
    let at = |x: usize, y: usize| plane.at(x.min(width - 1), y.min(height - 1));
    let mean = |x: usize, y: usize| 0.25 * (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1));
    let span = |low: usize, high: usize| STRIDE as f32 / high.saturating_sub(low).max(1) as f32;
    let (left, right) = (x.saturating_sub(HALF), (x + HALF).min(width - 1));
    let (above, below) = (y.saturating_sub(HALF), (y + HALF).min(height - 1));
    [
        mean(x, y),
        (mean(right, y) - mean(left, y)) * span(left, right),
        (mean(x, below) - mean(x, above)) * span(above, below),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    #[test]
    fn a_quadratic_flow_is_reproduced_between_nodes() {
        let grid = FineGrid::over(64, 48);
        let u = |x: f32, y: f32| 1.0 + 0.05 * x - 0.03 * y + 2e-3 * (x * x - y * y + 0.5 * x * y);
        let flow = FlowField {
            u: Image::from_fn(64, 48, |x, y| u(x as f32, y as f32)),
            v: Image::from_fn(64, 48, |x, y| -u(y as f32, x as f32)),
        };
        let mut field = FineField::new(grid);
        let place = 5 * grid.columns + 7;
        field.sample(&flow, &mut [FineNode::at(place, 0.0)]);
        let cells = [place, place + 1, place + grid.columns, place + grid.columns + 1];
        field.set_twists(&cells);
        for cell in cells {
            let (left, top) = grid.upper_left(cell);
            let [found_u, found_v] = dispatch!(Level::new(), simd => field.flow(simd, cell));
            for k in 0..CELL {
                let (x, y) = (left + k % STRIDE, top + k / STRIDE);
                // The mean of four pixels exceeds a quadratic's value between them by a quarter of its curvatures' sum.
                assert!((found_u[k] - flow.u.at(x, y)).abs() < 2e-3, "u at ({x}, {y})");
                assert!((found_v[k] - flow.v.at(x, y)).abs() < 2e-3, "v at ({x}, {y})");
            }
        }
    }
}

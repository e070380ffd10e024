//! The flow as affine models at the nodes of the patch grid.
//!
//! Every node has the displacement and its gradient per stride: `(u, ∂u/∂x, ∂u/∂y, v, ∂v/∂x, ∂v/∂y)`, six planes in
//! total.

use super::grid::{MARGIN, PatchGrid, STRIDE};
use crate::FlowField;
use crate::search::coarse_neighbours;
use crate::search::local::CellMotion;

/// Unknowns of a node.
pub(crate) const UNKNOWNS: usize = 6;

/// One value per unknown and node.
pub(crate) type Planes = [Vec<f32>; UNKNOWNS];

/// How much a change counts, given the square of its length in pixels of the level that it was found on:
/// `m⁴/(m⁴ + z⁴)` with `z` a tenth of a pixel. Smaller changes are mostly noise.
fn trust_of(square: f32) -> f32 {
    const HALF: f32 = 1e-4;
    let fourth = square * square;
    fourth / (fourth + HALF)
}

/// Six planes over the nodes, row by row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct NodeField {
    pub(crate) grid: PatchGrid,
    pub(crate) planes: Planes,
}

impl NodeField {
    /// Zero displacement.
    pub(crate) fn zero(grid: PatchGrid) -> Self {
        Self { grid, planes: std::array::from_fn(|_| vec![0.0; grid.plane_len()]) }
    }

    /// Copies a field of the same grid.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        for (plane, other) in self.planes.iter_mut().zip(&other.planes) {
            plane.copy_from_slice(other);
        }
    }

    /// Writes for every node whether its point lies in the current image.
    pub(crate) fn mark_inside(&self, is_inside: &mut [bool]) {
        let (right, bottom) = (self.grid.width as f32 - 1.0, self.grid.height as f32 - 1.0);
        // The outermost centres lie up to half a stride outside the image even at rest.
        let margin = MARGIN as f32;
        let columns = self.grid.columns;
        let rows = self.planes[0].chunks(columns).zip(self.planes[3].chunks(columns));
        for (j, (is_inside, (u, v))) in is_inside.chunks_mut(columns).zip(rows).enumerate() {
            let centre_y = PatchGrid::centre(j);
            for (i, (is_inside, (u, v))) in is_inside.iter_mut().zip(u.iter().zip(v)).enumerate() {
                let (x, y) = (PatchGrid::centre(i) + u, centre_y + v);
                *is_inside = x >= -margin && y >= -margin && x <= right + margin && y <= bottom + margin;
            }
        }
    }

    /// Composes the field with an increment `δ` in the coordinates of the template: `u ← u + (I + ∇u) δ`, to first
    /// order.
    pub(crate) fn compose(&mut self, increment: &Self) {
        let d = &increment.planes;
        for first in [0, 3] {
            let [u, ux, uy] = self.planes[first..].first_chunk_mut().expect("three planes of one component");
            let n = u.len();
            let (ux, uy) = (&mut ux[..n], &mut uy[..n]);
            let d = d.each_ref().map(|plane| &plane[..n]);
            let [du, dux, duy] = [d[first], d[first + 1], d[first + 2]];
            for i in 0..n {
                let (gx, gy) = (ux[i] / STRIDE as f32, uy[i] / STRIDE as f32);
                u[i] += du[i] + gx * d[0][i] + gy * d[3][i];
                ux[i] += dux[i] + gx * d[1][i] + gy * d[4][i];
                uy[i] += duy[i] + gx * d[2][i] + gy * d[5][i];
            }
        }
    }

    /// Sets the motion at a node.
    pub(crate) fn set_motion(&mut self, node: usize, CellMotion { displacement, gradient }: CellMotion) {
        for component in 0..2 {
            self.planes[3 * component][node] = displacement[component];
            for (k, slope) in gradient[component].into_iter().enumerate() {
                self.planes[3 * component + 1 + k][node] = slope * STRIDE as f32;
            }
        }
    }

    /// Sets the field from that of the next finer level: means of 2×2 nodes, displacements halved.
    pub(crate) fn coarsen(&mut self, fine: &Self) {
        let (columns, rows) = (fine.grid.columns, fine.grid.rows);
        for (p, (plane, fine)) in self.planes.iter_mut().zip(&fine.planes).enumerate() {
            // A displacement halves with the pixel; its gradient does not.
            let scale = if p % 3 == 0 { 0.125 } else { 0.25 };
            for j in 0..self.grid.rows {
                let (above, below) = (2 * j * columns, (2 * j + 1).min(rows - 1) * columns);
                for i in 0..self.grid.columns {
                    let (left, right) = (2 * i, (2 * i + 1).min(columns - 1));
                    let sum = fine[above + left] + fine[above + right] + fine[below + left] + fine[below + right];
                    plane[j * self.grid.columns + i] = scale * sum;
                }
            }
        }
    }

    /// Adds `change`, an increment found on the next coarser level.
    ///
    /// A coarse level cannot distinguish a change that is small relative to its pixels from its own error. Such changes
    /// are damped; the finer levels then find them.
    pub(crate) fn add_change(&mut self, change: &Self) {
        let columns = change.grid.columns;
        for j in 0..self.grid.rows {
            let (near_j, far_j) = coarse_neighbours(j, change.grid.rows);
            for i in 0..self.grid.columns {
                let (near_i, far_i) = coarse_neighbours(i, columns);
                let corners = [
                    (near_j * columns + near_i, 0.5625),
                    (near_j * columns + far_i, 0.1875),
                    (far_j * columns + near_i, 0.1875),
                    (far_j * columns + far_i, 0.0625),
                ];
                let at = |p: usize| corners.iter().map(|&(node, weight)| weight * change.planes[p][node]).sum::<f32>();
                let changes: [f32; UNKNOWNS] = std::array::from_fn(at);
                let trust = trust_of(changes[0] * changes[0] + changes[3] * changes[3]);
                for (p, plane) in self.planes.iter_mut().enumerate() {
                    let scale = if p % 3 == 0 { 2.0 } else { 1.0 };
                    plane[j * self.grid.columns + i] += trust * scale * changes[p];
                }
            }
        }
    }

    /// Converts the field of the frame before `last` to a prediction of the next one: `last` and its change since then.
    /// Returns whether any node moves fast enough for a prediction to help. Small changes are damped.
    pub(crate) fn extrapolate(&mut self, last: &Self) -> bool {
        let mut is_moving = false;
        for node in 0..self.grid.nodes() {
            let square = (0..2).map(|c| (last.planes[3 * c][node] - self.planes[3 * c][node]).powi(2)).sum::<f32>();
            let trust = trust_of(square);
            is_moving |= trust > 0.5;
            let share = 1.0 + trust;
            for (plane, last) in self.planes.iter_mut().zip(&last.planes) {
                plane[node] += share * (last[node] - plane[node]);
            }
        }
        is_moving
    }

    /// Takes over the nodes of another field that are selected by their column and row.
    pub(crate) fn take(&mut self, other: &Self, is_selected: impl Fn(usize, usize) -> bool) {
        for j in 0..self.grid.rows {
            for i in (0..self.grid.columns).filter(|&i| is_selected(i, j)) {
                self.take_node(j * self.grid.columns + i, other);
            }
        }
    }

    fn take_node(&mut self, node: usize, other: &Self) {
        for (plane, other) in self.planes.iter_mut().zip(&other.planes) {
            plane[node] = other[node];
        }
    }

    /// Sets every failed node to the mean of its neighbours' affine predictions, ring by ring outwards from the valid
    /// nodes. `rings` is scratch memory of a plane's length.
    pub(crate) fn fill_failed(&mut self, trust: &[f32], rings: &mut [usize]) {
        let (columns, nodes) = (self.grid.columns, self.grid.nodes());
        for (ring, trust) in rings.iter_mut().zip(trust) {
            *ring = if *trust > 0.0 { 0 } else { usize::MAX };
        }
        let mut missing = rings[..nodes].iter().filter(|&&ring| ring > 0).count();
        for ring in 1..=columns + self.grid.rows {
            if missing == 0 {
                return;
            }
            for node in 0..nodes {
                if rings[node] < ring {
                    continue;
                }
                let neighbours = [
                    (node % columns > 0).then(|| (node - 1, 1, 1.0)),
                    ((node + 1) % columns > 0).then_some((node + 1, 1, -1.0)),
                    node.checked_sub(columns).map(|above| (above, 2, 1.0)),
                    (node + columns < nodes).then_some((node + columns, 2, -1.0)),
                ];
                let mut sums = [0.0; UNKNOWNS];
                let mut count = 0.0;
                for (from, slope, sign) in neighbours.into_iter().flatten().filter(|&(from, ..)| rings[from] < ring) {
                    count += 1.0;
                    for (p, sum) in sums.iter_mut().enumerate() {
                        let step = if p % 3 == 0 { sign * self.planes[p + slope][from] } else { 0.0 };
                        *sum += self.planes[p][from] + step;
                    }
                }
                if count > 0.0 {
                    missing -= 1;
                    rings[node] = ring;
                    for (plane, sum) in self.planes.iter_mut().zip(sums) {
                        plane[node] = sum / count;
                    }
                }
            }
        }
    }

    /// Sets every failed node whose displacement is more than `farthest` px away from that in `filled` to the values there.
    pub(crate) fn recall(&mut self, trust: &[f32], filled: &Self, farthest: f32) {
        for (node, _) in trust[..self.grid.nodes()].iter().enumerate().filter(|(_, trust)| **trust <= 0.0) {
            let [right, down] = [0, 3].map(|plane| self.planes[plane][node] - filled.planes[plane][node]);
            if right.hypot(down) > farthest {
                self.take_node(node, filled);
            }
        }
    }

    /// Sets the field to `new − old`.
    pub(crate) fn set_difference(&mut self, new: &Self, old: &Self) {
        for (plane, (new, old)) in self.planes.iter_mut().zip(new.planes.iter().zip(&old.planes)) {
            for (value, (new, old)) in plane.iter_mut().zip(new.iter().zip(old)) {
                *value = new - old;
            }
        }
    }

    /// Sets the field to values and central differences of a dense flow at the nodes.
    pub(crate) fn sample(&mut self, flow: &FlowField) {
        let (width, height) = flow.size();
        let half = STRIDE / 2;
        let span = |low: usize, high: usize| STRIDE as f32 / high.saturating_sub(low).max(1) as f32;
        for j in 0..self.grid.rows {
            // The node lies between pixels; the mean of the four around it is the value there.
            let y = STRIDE * j + MARGIN - 1;
            let (above, below) = (y.saturating_sub(half), (y + half).min(height - 1));
            for (first, plane) in [(0, &flow.u), (3, &flow.v)] {
                let pair = |y: usize| [y, y + 1].map(|y| plane.row(y.min(height - 1)));
                let (here, upper, lower) = (pair(y), pair(above), pair(below));
                for i in 0..self.grid.columns {
                    let x = STRIDE * i + MARGIN - 1;
                    let (left, right) = (x.saturating_sub(half), (x + half).min(width - 1));
                    let n = j * self.grid.columns + i;
                    let inner = if x >= half { means(here, left) } else { None };
                    let [at_left, centre, at_right] = inner.unwrap_or_else(|| [left, x, right].map(|x| mean(here, x)));
                    self.planes[first][n] = centre;
                    self.planes[first + 1][n] = (at_right - at_left) * span(left, right);
                    self.planes[first + 2][n] = (mean(lower, x) - mean(upper, x)) * span(above, below);
                }
            }
        }
    }
}

/// As [`mean`], at `left`, half a stride to its right and a stride to its right; none if this is not all in the rows. Checked once, it
/// takes a third of the time of three means.
fn means(rows: [&[f32]; 2], left: usize) -> Option<[f32; 3]> {
    let [upper, lower]: [Option<&[f32; STRIDE + 2]>; 2] = rows.map(|row| row.get(left..)?.first_chunk());
    let (upper, lower) = (upper?, lower?);
    Some([0, STRIDE / 2, STRIDE].map(|x| 0.25 * (upper[x] + upper[x + 1] + lower[x] + lower[x + 1])))
}

/// The mean of two pixels, those at `x` and to its right, in each of two rows.
fn mean(rows: [&[f32]; 2], x: usize) -> f32 {
    let last = rows[0].len() - 1;
    let (left, right) = (x.min(last), (x + 1).min(last));
    0.25 * (rows[0][left] + rows[0][right] + rows[1][left] + rows[1][right])
}

#[cfg(test)]
mod tests {
    use super::*;
    use fingervision_image::Image;

    #[test]
    fn samples_of_an_affine_flow_are_its_values_and_slopes() {
        let (width, height) = (80, 64);
        let plane = |a: f32, b: f32| Image::from_fn(width, height, |x, y| a * x as f32 + b * y as f32);
        let flow = FlowField { u: plane(0.5, -0.25), v: plane(0.125, 1.0) };
        let mut field = NodeField::zero(PatchGrid::over(width, height));
        field.sample(&flow);
        for (i, j) in [(0, 0), (1, 3), (4, 4), (0, 5), (8, 2)] {
            let n = j * field.grid.columns + i;
            let [x, y] = [i, j].map(PatchGrid::centre);
            let values = field.planes.each_ref().map(|plane| plane[n]);
            let slope = STRIDE as f32;
            let expected = [0.5 * x - 0.25 * y, 0.5 * slope, -0.25 * slope, 0.125 * x + y, 0.125 * slope, slope];
            for (k, (value, expected)) in values.into_iter().zip(expected).enumerate() {
                assert!((value - expected).abs() < 1e-3, "node ({i}, {j}), value {k}: {value} instead of {expected}");
            }
        }
    }

    #[test]
    fn failed_nodes_are_filled_from_the_field_around_them() {
        let grid = PatchGrid::over(80, 64);
        let affine = |node: usize| {
            let (i, j) = ((node % grid.columns) as f32, (node / grid.columns) as f32);
            [1.0 + 0.5 * i - 0.25 * j, 0.5, -0.25, 2.0 - i, -1.0, 0.0]
        };
        let mut field = NodeField::zero(grid);
        let mut trust = vec![1.0; grid.plane_len()];
        for node in 0..grid.nodes() {
            let (i, j) = (node % grid.columns, node / grid.columns);
            let is_known = !(i < 3 || (5..8).contains(&i) && (2..5).contains(&j));
            trust[node] = f32::from(u8::from(is_known));
            for (plane, value) in field.planes.iter_mut().zip(affine(node)) {
                plane[node] = if is_known { value } else { 99.0 };
            }
        }
        field.fill_failed(&trust, &mut vec![0; grid.plane_len()]);
        for node in 0..grid.nodes() {
            for (plane, value) in field.planes.iter().zip(affine(node)) {
                assert!((plane[node] - value).abs() < 1e-4, "node {node}: {} against {value}", plane[node]);
            }
        }
    }

    #[test]
    fn only_failed_nodes_that_are_far_from_their_neighbours_are_recalled() {
        let grid = PatchGrid::over(80, 64);
        let (valid, near, far) = (12, 25, 38);
        let mut trust = vec![1.0; grid.plane_len()];
        (trust[near], trust[far]) = (0.0, 0.0);
        let mut field = NodeField::zero(grid);
        for (node, right, slope) in [(valid, 9.0, 0.0), (near, 1.5, 0.25), (far, -60.0, 3.0)] {
            (field.planes[0][node], field.planes[2][node]) = (right, slope);
        }
        let mut filled = field.clone();
        filled.fill_failed(&trust, &mut vec![0; grid.plane_len()]);
        field.recall(&trust, &filled, 2.0);
        let values = |node: usize| (field.planes[0][node], field.planes[2][node]);
        assert_eq!((values(valid), values(near), values(far)), ((9.0, 0.0), (1.5, 0.25), (0.0, 0.0)));
    }
}

//! The flow as affine models at the nodes of the patch grid, and its interpolation at pixels.
//!
//! Every node has the displacement and its gradient per stride: `(u, ∂u/∂x, ∂u/∂y, v, ∂v/∂x, ∂v/∂y)`, six planes in
//! total. Between nodes the field is the bicubic Hermite interpolant, which is continuous with its gradient and
//! represents any quadratic without error; beyond the outermost nodes it is extrapolated linearly.

use super::grid::{MARGIN, PatchGrid, STRIDE};
use crate::FlowField;
use crate::search::coarse_neighbours;
use crate::search::local::CellMotion;

/// Unknowns of a node.
pub(crate) const UNKNOWNS: usize = 6;

/// Fourth power of the change, px of the coarser level, that is damped to half.
const FADE: f32 = 1e-4;

/// One value per unknown and node.
pub(crate) type Planes = [Vec<f32>; UNKNOWNS];

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

    /// Whether a node's point lies in the current image.
    pub(crate) fn is_inside(&self, node: usize) -> bool {
        let (i, j) = (node % self.grid.columns, node / self.grid.columns);
        let (x, y) = (PatchGrid::centre(i) + self.planes[0][node], PatchGrid::centre(j) + self.planes[3][node]);
        let (right, bottom) = (self.grid.width as f32 - 1.0, self.grid.height as f32 - 1.0);
        // The outermost centres lie up to half a stride outside the image even at rest.
        let margin = MARGIN as f32;
        x >= -margin && y >= -margin && x <= right + margin && y <= bottom + margin
    }

    /// Composes the field with an increment `δ` in the coordinates of the template: `u ← u + (I + ∇u) δ`, to first
    /// order.
    pub(crate) fn compose(&mut self, increment: &Self) {
        let d = &increment.planes;
        for first in [0, 3] {
            let [u, ux, uy] = self.planes[first..].first_chunk_mut().expect("three planes of one component");
            for i in 0..u.len() {
                let (gx, gy) = (ux[i] / STRIDE as f32, uy[i] / STRIDE as f32);
                u[i] += d[first][i] + gx * d[0][i] + gy * d[3][i];
                ux[i] += d[first + 1][i] + gx * d[1][i] + gy * d[4][i];
                uy[i] += d[first + 2][i] + gx * d[2][i] + gy * d[5][i];
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
    /// are damped by `m⁴/(m⁴ + z⁴)`, with the length `m` of the change and `z` a tenth of a coarse pixel. The finer
    /// levels then find them.
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
                let length = (changes[0] * changes[0] + changes[3] * changes[3]).powi(2);
                let trust = length / (length + FADE);
                for (p, plane) in self.planes.iter_mut().enumerate() {
                    let scale = if p % 3 == 0 { 2.0 } else { 1.0 };
                    plane[j * self.grid.columns + i] += trust * scale * changes[p];
                }
            }
        }
    }

    /// Converts the field of the frame before `last` to a prediction of the next one: `last` and its change since then.
    /// Returns whether any node moves fast enough for a prediction to help.
    ///
    /// Small changes are mostly noise. They are damped like those of a coarse level, with `z` a tenth of a pixel.
    pub(crate) fn extrapolate(&mut self, last: &Self) -> bool {
        let mut is_moving = false;
        for node in 0..self.grid.nodes() {
            let square = (0..2).map(|c| (last.planes[3 * c][node] - self.planes[3 * c][node]).powi(2)).sum::<f32>();
            is_moving |= square > FADE.sqrt();
            let length = square * square;
            let share = 1.0 + length / (length + FADE);
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
                for (plane, other) in self.planes.iter_mut().zip(&other.planes) {
                    plane[j * self.grid.columns + i] = other[j * self.grid.columns + i];
                }
            }
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
        let at =
            |plane: &fingervision_image::Image<f32>, x: usize, y: usize| plane.at(x.min(width - 1), y.min(height - 1));
        let half = STRIDE / 2;
        for j in 0..self.grid.rows {
            for i in 0..self.grid.columns {
                // The node lies between pixels; the mean of the four around it is the value there.
                let (x, y) = (STRIDE * i + MARGIN - 1, STRIDE * j + MARGIN - 1);
                for (first, plane) in [(0, &flow.u), (3, &flow.v)] {
                    let mean = |x: usize, y: usize| {
                        0.25 * (at(plane, x, y) + at(plane, x + 1, y) + at(plane, x, y + 1) + at(plane, x + 1, y + 1))
                    };
                    let n = j * self.grid.columns + i;
                    let (left, right) = (x.saturating_sub(half), (x + half).min(width - 1));
                    let (above, below) = (y.saturating_sub(half), (y + half).min(height - 1));
                    self.planes[first][n] = mean(x, y);
                    let span = |low: usize, high: usize| STRIDE as f32 / high.saturating_sub(low).max(1) as f32;
                    self.planes[first + 1][n] = (mean(right, y) - mean(left, y)) * span(left, right);
                    self.planes[first + 2][n] = (mean(x, below) - mean(x, above)) * span(above, below);
                }
            }
        }
    }
}

/// Hermite basis at the eight pixels between two nodes.
#[derive(Debug, Clone)]
struct HermiteBasis {
    value_0: [f32; STRIDE],
    slope_0: [f32; STRIDE],
    value_1: [f32; STRIDE],
    slope_1: [f32; STRIDE],
}

impl HermiteBasis {
    fn new() -> Self {
        let at = |f: fn(f32) -> f32| std::array::from_fn(|k| f((k as f32 + 0.5) / STRIDE as f32));
        Self {
            value_0: at(|t| (1.0 + 2.0 * t) * (1.0 - t) * (1.0 - t)),
            slope_0: at(|t| t * (1.0 - t) * (1.0 - t)),
            value_1: at(|t| t * t * (3.0 - 2.0 * t)),
            slope_1: at(|t| t * t * (t - 1.0)),
        }
    }
}

/// Interpolates node fields at rows of pixels.
#[derive(Debug, Clone)]
pub(crate) struct Expander {
    grid: PatchGrid,
    basis: HermiteBasis,
    /// Mixed second derivative of u and v at the nodes, per stride².
    twist: [Vec<f32>; 2],
    /// Value and x slope of u and v along one row of pixels, with one extrapolated node on either side.
    line: [Vec<f32>; 4],
}

impl Expander {
    pub(crate) fn new(grid: PatchGrid) -> Self {
        Self {
            grid,
            basis: HermiteBasis::new(),
            twist: std::array::from_fn(|_| vec![0.0; grid.plane_len()]),
            line: std::array::from_fn(|_| vec![0.0; grid.columns + 2]),
        }
    }

    /// Sets a new field: call before [`Expander::row`].
    pub(crate) fn prepare(&mut self, field: &NodeField) {
        let (columns, rows) = (self.grid.columns, self.grid.rows);
        for (twist, first) in self.twist.iter_mut().zip([0, 3]) {
            let (slope_x, slope_y) = (&field.planes[first + 1], &field.planes[first + 2]);
            for j in 0..rows {
                let (above, below) = (j.saturating_sub(1), (j + 1).min(rows - 1));
                let span_y = (below - above).max(1) as f32;
                for i in 0..columns {
                    let (left, right) = (i.saturating_sub(1), (i + 1).min(columns - 1));
                    let span_x = (right - left).max(1) as f32;
                    let along_y = (slope_x[below * columns + i] - slope_x[above * columns + i]) / span_y;
                    let along_x = (slope_y[j * columns + right] - slope_y[j * columns + left]) / span_x;
                    twist[j * columns + i] = 0.5 * (along_x + along_y);
                }
            }
        }
    }

    /// Writes the displacement along padded row `row`: `out[0]` to the right and `out[1]` downwards, px, at every
    /// padded column up to `STRIDE·(columns + 1)`.
    #[inline(always)]
    pub(crate) fn row(&mut self, field: &NodeField, row: usize, out: [&mut [f32]; 2]) {
        self.interpolate_line(field, row);
        for (component, out) in out.into_iter().enumerate() {
            let (value, slope) = (&self.line[2 * component], &self.line[2 * component + 1]);
            let nodes = value.windows(2).zip(slope.windows(2));
            let (cells, _) = out.as_chunks_mut::<STRIDE>();
            for (cell, (value, slope)) in cells.iter_mut().zip(nodes) {
                for k in 0..STRIDE {
                    cell[k] = self.basis.value_0[k] * value[0]
                        + self.basis.slope_0[k] * slope[0]
                        + self.basis.value_1[k] * value[1]
                        + self.basis.slope_1[k] * slope[1];
                }
            }
        }
    }

    /// Interpolates value and x slope vertically at every node column.
    #[inline(always)]
    fn interpolate_line(&mut self, field: &NodeField, row: usize) {
        let columns = self.grid.columns;
        let (below, k) = (row / STRIDE, row % STRIDE);
        let outside = below == 0 || below == self.grid.rows;
        for component in 0..2 {
            let [value, slope_x, slope_y] =
                field.planes[3 * component..].first_chunk().expect("three planes of one component");
            let twist = &self.twist[component];
            let (line_value, line_slope) = {
                let (a, b) = self.line.split_at_mut(2 * component + 1);
                (&mut a[2 * component], &mut b[0])
            };
            let inner_value = &mut line_value[1..=columns];
            let inner_slope = &mut line_slope[1..=columns];
            if outside {
                let start = columns * below.min(self.grid.rows - 1);
                let distance = (k as f32 + 0.5) / STRIDE as f32 - if below == 0 { 1.0 } else { 0.0 };
                for i in 0..columns {
                    inner_value[i] = value[start + i] + distance * slope_y[start + i];
                    inner_slope[i] = slope_x[start + i] + distance * twist[start + i];
                }
            } else {
                let (a, b) = ((below - 1) * columns, below * columns);
                let HermiteBasis { value_0, slope_0, value_1, slope_1 } = &self.basis;
                let (h0, g0, h1, g1) = (value_0[k], slope_0[k], value_1[k], slope_1[k]);
                for i in 0..columns {
                    inner_value[i] = h0 * value[a + i] + g0 * slope_y[a + i] + h1 * value[b + i] + g1 * slope_y[b + i];
                    inner_slope[i] = h0 * slope_x[a + i] + g0 * twist[a + i] + h1 * slope_x[b + i] + g1 * twist[b + i];
                }
            }
            line_value[0] = line_value[1] - line_slope[1];
            line_slope[0] = line_slope[1];
            line_value[columns + 1] = line_value[columns] + line_slope[columns];
            line_slope[columns + 1] = line_slope[columns];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fingervision_image::Image;

    #[test]
    fn a_quadratic_field_is_reproduced_between_nodes() {
        let (width, height) = (61, 45);
        let u = |x: f32, y: f32| 2.0 + 0.03 * x - 0.02 * y + 1e-3 * (x * x - 2.0 * y * y + x * y);
        let grid = PatchGrid::over(width, height);
        let mut field = NodeField::zero(grid);
        for j in 0..grid.rows {
            for i in 0..grid.columns {
                let (x, y) = (PatchGrid::centre(i), PatchGrid::centre(j));
                let n = j * grid.columns + i;
                field.planes[0][n] = u(x, y);
                field.planes[1][n] = STRIDE as f32 * (0.03 + 1e-3 * (2.0 * x + y));
                field.planes[2][n] = STRIDE as f32 * (-0.02 + 1e-3 * (-4.0 * y + x));
            }
        }
        let mut expander = Expander::new(grid);
        expander.prepare(&field);
        let mut out = [vec![0.0; grid.padded_width()], vec![0.0; grid.padded_width()]];
        for row in 2 * STRIDE..STRIDE * (grid.rows - 1) {
            let [a, b] = &mut out;
            expander.row(&field, row, [a, b]);
            for column in 2 * STRIDE..STRIDE * (grid.columns - 1) {
                let (x, y) = (column as f32 - MARGIN as f32, row as f32 - MARGIN as f32);
                assert!((a[column] - u(x, y)).abs() < 1e-3, "({x}, {y}): {} against {}", a[column], u(x, y));
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
    fn an_affine_field_is_sampled_and_extrapolated_beyond_the_border() {
        let (width, height) = (50, 37);
        let v = |x: f32, y: f32| 1.0 - 0.05 * x + 0.04 * y;
        let flow = FlowField {
            u: Image::filled(width, height, 0.0),
            v: Image::from_fn(width, height, |x, y| v(x as f32, y as f32)),
        };
        let grid = PatchGrid::over(width, height);
        let mut field = NodeField::zero(grid);
        field.sample(&flow);
        let mut expander = Expander::new(grid);
        expander.prepare(&field);
        let mut out = [vec![0.0; grid.padded_width()], vec![0.0; grid.padded_width()]];
        for y in 0..height {
            let [a, b] = &mut out;
            expander.row(&field, y + MARGIN, [a, b]);
            for x in 0..width - MARGIN {
                let expected = v(x as f32, y as f32);
                assert!((b[x + MARGIN] - expected).abs() < 0.08, "({x}, {y}): {} against {expected}", b[x + MARGIN]);
            }
        }
    }
}

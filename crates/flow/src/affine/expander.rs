//! The flow at pixels, interpolated between the nodes of the patch grid.
//!
//! Between nodes the field is the bicubic Hermite interpolant, which is continuous with its gradient and represents any
//! quadratic without error; beyond the outermost nodes it is extrapolated linearly.

use super::grid::{PatchGrid, STRIDE};
use super::nodes::NodeField;
use crate::multiply_add::multiply_add;
use fearless_simd::Simd;

/// Hermite basis at the eight pixels between two nodes.
#[derive(Debug, Clone, Copy)]
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
}

/// Value and x slope of u and v along one row of pixels, with one extrapolated node on either side: scratch memory.
#[derive(Debug, Clone)]
pub(crate) struct Line([Vec<f32>; 4]);

impl Line {
    /// For fields of this grid.
    pub(crate) fn new(grid: PatchGrid) -> Self {
        Self(std::array::from_fn(|_| vec![0.0; grid.columns + 2]))
    }
}

impl Expander {
    pub(crate) fn new(grid: PatchGrid) -> Self {
        Self { grid, basis: HermiteBasis::new(), twist: std::array::from_fn(|_| vec![0.0; grid.plane_len()]) }
    }

    /// Sets a new field: call before [`Expander::row`].
    pub(crate) fn prepare(&mut self, field: &NodeField) {
        let (columns, rows) = (self.grid.columns, self.grid.rows);
        for (twist, first) in self.twist.iter_mut().zip([0, 3]) {
            let (slope_x, slope_y) = (&field.planes[first + 1], &field.planes[first + 2]);
            for (j, twist) in twist.chunks_exact_mut(columns).take(rows).enumerate() {
                let (above, below) = (j.saturating_sub(1), (j + 1).min(rows - 1));
                let per_row = 1.0 / (below - above).max(1) as f32;
                let at = |row: usize| row * columns..(row + 1) * columns;
                let (upper, lower, here) = (&slope_x[at(above)], &slope_x[at(below)], &slope_y[at(j)]);
                for (twist, (upper, lower)) in twist.iter_mut().zip(upper.iter().zip(lower)) {
                    *twist = 0.5 * per_row * (lower - upper);
                }
                let inner = twist[1..].iter_mut().zip(here.iter().zip(&here[2.min(columns)..]));
                for (twist, (left, right)) in inner {
                    *twist += 0.25 * (right - left);
                }
                let last = columns - 1;
                twist[0] += 0.5 * (here[1.min(last)] - here[0]);
                if last > 0 {
                    twist[last] += 0.5 * (here[last] - here[last - 1]);
                }
            }
        }
    }

    /// Writes the displacement along padded row `row`: `out[0]` to the right and `out[1]` downwards, px, at every
    /// padded column up to `STRIDE·(columns + 1)`.
    #[inline(always)]
    pub(crate) fn row<S: Simd>(&self, simd: S, line: &mut Line, field: &NodeField, row: usize, out: [&mut [f32]; 2]) {
        self.interpolate(simd, line, field, row);
        let HermiteBasis { value_0, slope_0, value_1, slope_1 } = self.basis;
        for (component, out) in out.into_iter().enumerate() {
            let (value, slope) = (&line.0[2 * component], &line.0[2 * component + 1]);
            let nodes = value.windows(2).zip(slope.windows(2));
            let (cells, _) = out.as_chunks_mut::<STRIDE>();
            for (cell, (value, slope)) in cells.iter_mut().zip(nodes) {
                let (left, right) = ([value[0], slope[0]], [value[1], slope[1]]);
                for k in 0..STRIDE {
                    let sum = multiply_add(simd, slope_0[k], left[1], value_0[k] * left[0]);
                    let sum = multiply_add(simd, value_1[k], right[0], sum);
                    cell[k] = multiply_add(simd, slope_1[k], right[1], sum);
                }
            }
        }
    }

    /// Interpolates value and x slope vertically at every node column.
    #[inline(always)]
    fn interpolate<S: Simd>(&self, simd: S, line: &mut Line, field: &NodeField, row: usize) {
        let columns = self.grid.columns;
        let (below, k) = (row / STRIDE, row % STRIDE);
        let outside = below == 0 || below == self.grid.rows;
        for component in 0..2 {
            let [value, slope_x, slope_y] =
                field.planes[3 * component..].first_chunk().expect("three planes of one component");
            let twist = &self.twist[component];
            let (line_value, line_slope) = {
                let (a, b) = line.0.split_at_mut(2 * component + 1);
                (&mut a[2 * component], &mut b[0])
            };
            let (inner_value, inner_slope) = (&mut line_value[1..][..columns], &mut line_slope[1..][..columns]);
            let at = |row: usize| [value, slope_x, slope_y, twist].map(|plane| &plane[row * columns..][..columns]);
            if outside {
                let [value, slope_x, slope_y, twist] = at(below.min(self.grid.rows - 1));
                let distance = (k as f32 + 0.5) / STRIDE as f32 - if below == 0 { 1.0 } else { 0.0 };
                for i in 0..columns {
                    inner_value[i] = value[i] + distance * slope_y[i];
                    inner_slope[i] = slope_x[i] + distance * twist[i];
                }
            } else {
                let (upper, lower) = (at(below - 1), at(below));
                let HermiteBasis { value_0, slope_0, value_1, slope_1 } = &self.basis;
                let weights = [value_0[k], slope_0[k], value_1[k], slope_1[k]];
                combine(simd, weights, [upper[0], upper[2], lower[0], lower[2]], inner_value);
                combine(simd, weights, [upper[1], upper[3], lower[1], lower[3]], inner_slope);
            }
            line_value[0] = line_value[1] - line_slope[1];
            line_slope[0] = line_slope[1];
            line_value[columns + 1] = line_value[columns] + line_slope[columns];
            line_slope[columns + 1] = line_slope[columns];
        }
    }
}

/// The weighted sum of four rows of nodes. The slices have one length, so that the loop is vectorised.
#[inline(always)]
fn combine<S: Simd>(
    simd: S,
    [h0, g0, h1, g1]: [f32; 4],
    [value_0, slope_0, value_1, slope_1]: [&[f32]; 4],
    out: &mut [f32],
) {
    let n = out.len();
    let [value_0, slope_0, value_1, slope_1] = [value_0, slope_0, value_1, slope_1].map(|row| &row[..n]);
    for i in 0..n {
        let sum = multiply_add(simd, g0, slope_0[i], h0 * value_0[i]);
        let sum = multiply_add(simd, h1, value_1[i], sum);
        out[i] = multiply_add(simd, g1, slope_1[i], sum);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FlowField;
    use crate::affine::grid::MARGIN;
    use fearless_simd::{Level, dispatch};
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
        let (mut expander, mut line) = (Expander::new(grid), Line::new(grid));
        expander.prepare(&field);
        let mut out = [vec![0.0; grid.padded_width()], vec![0.0; grid.padded_width()]];
        for row in 2 * STRIDE..STRIDE * (grid.rows - 1) {
            let [a, b] = &mut out;
            dispatch!(Level::new(), simd => expander.row(simd, &mut line, &field, row, [a, b]));
            for column in 2 * STRIDE..STRIDE * (grid.columns - 1) {
                let (x, y) = (column as f32 - MARGIN as f32, row as f32 - MARGIN as f32);
                assert!((a[column] - u(x, y)).abs() < 1e-3, "({x}, {y}): {} against {}", a[column], u(x, y));
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
        let (mut expander, mut line) = (Expander::new(grid), Line::new(grid));
        expander.prepare(&field);
        let mut out = [vec![0.0; grid.padded_width()], vec![0.0; grid.padded_width()]];
        for y in 0..height {
            let [a, b] = &mut out;
            dispatch!(Level::new(), simd => expander.row(simd, &mut line, &field, y + MARGIN, [a, b]));
            for x in 0..width - MARGIN {
                let expected = v(x as f32, y as f32);
                assert!((b[x + MARGIN] - expected).abs() < 0.08, "({x}, {y}): {} against {expected}", b[x + MARGIN]);
            }
        }
    }
}

//! The thin-plate spline through scattered displacements, at every pixel.
//!
//! `f(x) = a + b·x + Σ w_i r_i² ln r_i` with `r_i = |x − x_i|`, `Σ w_i = 0` and `Σ w_i x_i = 0`, passes through all
//! points and has the least bending energy `∫∫ f_xx² + 2 f_xy² + f_yy²`. It is evaluated on nodes 4 px apart and
//! interpolated to the pixels by cubic convolution. This is accurate enough, because the dots are tens of px apart and
//! the field is smooth over that distance.

use fingervision_image::Image;
use nalgebra::{DMatrix, Dyn, LU};

/// Distance between nodes, px.
const STEP: usize = 4;

/// A spline through values at fixed points, for images of one size.
#[derive(Debug, Clone)]
pub(super) struct ThinPlate {
    points: Vec<[f64; 2]>,
    /// Length that makes coordinates dimensionless, px.
    scale_px: f64,
    /// Number of nodes along x and y; the first one lies one step before the image.
    nodes: (usize, usize),
    /// A row for every node, a column for every point.
    kernel: DMatrix<f32>,
    /// The linear system for the points in use, and these points.
    solver: Option<(Vec<bool>, LU<f64, Dyn, Dyn>)>,
    values: Vec<f32>,
}

impl ThinPlate {
    pub(super) fn new(points: &[[f64; 2]], scale_px: f64, (width, height): (usize, usize)) -> Self {
        // One node before the first pixel, and two behind the last.
        let nodes = ((width - 1) / STEP + 4, (height - 1) / STEP + 4);
        let kernel = DMatrix::from_fn(nodes.0 * nodes.1, points.len(), |node, point| {
            radial(node_place(node, nodes), points[point], scale_px) as f32
        });
        let values = vec![0.0; nodes.0 * nodes.1];
        Self { points: points.to_vec(), scale_px, nodes, kernel, solver: None, values }
    }

    /// Writes the spline through these values at the points in use. Returns whether there is one: it needs three points
    /// or more, not all on one line.
    pub(super) fn interpolate_into(
        &mut self,
        values: &[[f64; 2]],
        in_use: &[bool],
        fields: [&mut Image<f32>; 2],
    ) -> bool {
        if self.solver.as_ref().is_none_or(|(points, _)| points != in_use) {
            self.solver = Some((in_use.to_vec(), self.system(in_use).lu()));
        }
        let Some((_, solver)) = &self.solver else { return false };
        let used: Vec<usize> = (0..self.points.len()).filter(|&point| in_use[point]).collect();
        if !self.is_plane(&used) {
            return false;
        }
        let right =
            DMatrix::from_fn(used.len() + 3, 2, |row, axis| used.get(row).map_or(0.0, |&point| values[point][axis]));
        let Some(weights) = solver.solve(&right).filter(|weights| weights.iter().all(|weight| weight.is_finite()))
        else {
            return false;
        };
        for (axis, field) in fields.into_iter().enumerate() {
            self.evaluate(&used, weights.column(axis).as_slice());
            self.carry_into(field);
        }
        true
    }

    /// Whether these points are not all on one line: their scatter has two directions.
    fn is_plane(&self, used: &[usize]) -> bool {
        let count = used.len() as f64;
        let mean = [0, 1].map(|axis| used.iter().map(|&point| self.points[point][axis]).sum::<f64>() / count);
        let sum = |a: usize, b: usize| {
            let products =
                used.iter().map(|&point| (self.points[point][a] - mean[a]) * (self.points[point][b] - mean[b]));
            products.sum::<f64>()
        };
        let (xx, xy, yy) = (sum(0, 0), sum(0, 1), sum(1, 1));
        used.len() >= 3 && xx * yy - xy * xy > 1e-6 * (xx + yy).powi(2)
    }

    /// The matrix of the conditions: a row for every point in use, and three for what must vanish.
    fn system(&self, in_use: &[bool]) -> DMatrix<f64> {
        let points: Vec<[f64; 2]> =
            self.points.iter().zip(in_use).filter(|(_, used)| **used).map(|(point, _)| *point).collect();
        let count = points.len();
        DMatrix::from_fn(count + 3, count + 3, |row, column| match (points.get(row), points.get(column)) {
            (Some(&a), Some(&b)) => radial(a, b, self.scale_px),
            (Some(&point), None) => self.plane(point)[column - count],
            (None, Some(&point)) => self.plane(point)[row - count],
            (None, None) => 0.0,
        })
    }

    fn plane(&self, [x, y]: [f64; 2]) -> [f64; 3] {
        [1.0, x / self.scale_px, y / self.scale_px]
    }

    /// The spline at every node.
    fn evaluate(&mut self, used: &[usize], weights: &[f64]) {
        let plane = &weights[used.len()..];
        for (node, value) in self.values.iter_mut().enumerate() {
            let [x, y] = node_place(node, self.nodes).map(|place| place / self.scale_px);
            *value = (plane[0] + plane[1] * x + plane[2] * y) as f32;
        }
        for (&point, &weight) in used.iter().zip(weights) {
            let weight = weight as f32;
            for (value, kernel) in self.values.iter_mut().zip(self.kernel.column(point).iter()) {
                *value += weight * kernel;
            }
        }
    }

    /// From nodes to pixels, by cubic convolution along rows and columns.
    fn carry_into(&self, field: &mut Image<f32>) {
        let (columns, _) = self.nodes;
        for (y, row) in field.rows_mut().enumerate() {
            let (node_y, down) = (y / STEP, cubic((y % STEP) as f32 / STEP as f32));
            for (x, value) in row.iter_mut().enumerate() {
                let (node_x, across) = (x / STEP, cubic((x % STEP) as f32 / STEP as f32));
                let mut sum = 0.0;
                for (j, down) in down.iter().enumerate() {
                    let nodes = &self.values[(node_y + j) * columns + node_x..][..4];
                    sum += down * nodes.iter().zip(&across).map(|(node, across)| node * across).sum::<f32>();
                }
                *value = sum;
            }
        }
    }
}

fn node_place(node: usize, (columns, _): (usize, usize)) -> [f64; 2] {
    [node % columns, node / columns].map(|number| (number * STEP) as f64 - STEP as f64)
}

/// `r² ln r`, dimensionless; 0 at 0.
fn radial(a: [f64; 2], b: [f64; 2], scale_px: f64) -> f64 {
    let squared = ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)) / (scale_px * scale_px);
    if squared > 0.0 { 0.5 * squared * squared.ln() } else { 0.0 }
}

/// Weights of the four nodes around a place between the inner two, 0 to 1 (Keys, *IEEE Transactions on Acoustics,
/// Speech, and Signal Processing* 29, 1981).
fn cubic(t: f32) -> [f32; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [0.5 * (-t + 2.0 * t2 - t3), 0.5 * (2.0 - 5.0 * t2 + 3.0 * t3), 0.5 * (t + 4.0 * t2 - 3.0 * t3), 0.5 * (t3 - t2)]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (usize, usize) = (150, 130);

    fn points() -> Vec<[f64; 2]> {
        (0..30).map(|k| [f64::from(k % 6) * 26.0 + 8.3, f64::from(k / 6) * 25.0 + 12.7]).collect()
    }

    fn interpolate(values: &[[f64; 2]], in_use: &[bool]) -> Option<[Image<f32>; 2]> {
        let [mut u, mut v] = [Image::filled(SIZE.0, SIZE.1, f32::NAN), Image::filled(SIZE.0, SIZE.1, f32::NAN)];
        let mut spline = ThinPlate::new(&points(), 26.0, SIZE);
        spline.interpolate_into(values, in_use, [&mut u, &mut v]).then_some([u, v])
    }

    #[test]
    fn a_plane_is_met_everywhere_even_with_points_missing() {
        let plane = |[x, y]: [f64; 2]| [3.0 + 0.02 * x - 0.05 * y, 0.01 * y - 1.0];
        let values: Vec<_> = points().into_iter().map(plane).collect();
        for missing in [None, Some(7)] {
            let in_use: Vec<bool> = (0..30).map(|point| Some(point) != missing).collect();
            let [u, v] = interpolate(&values, &in_use).unwrap();
            for (x, y) in [(0, 0), (149, 0), (75, 61), (149, 129), (34, 38)] {
                let [expected_u, expected_v] = plane([x as f64, y as f64]);
                let (u, v) = (f64::from(u.at(x, y)), f64::from(v.at(x, y)));
                assert!((u - expected_u).abs() < 1e-4 && (v - expected_v).abs() < 1e-4, "({u}, {v}) at {x} {y}");
            }
        }
    }

    #[test]
    fn the_spline_is_exact_at_the_nodes() {
        let bump = |[x, y]: [f64; 2]| {
            let far = ((x - 70.0).powi(2) + (y - 60.0).powi(2)) / 1800.0;
            [(x - 70.0) * 0.2 * (-far).exp(), (y - 60.0) * 0.2 * (-far).exp()]
        };
        let values: Vec<_> = points().into_iter().map(bump).collect();
        let [u, _] = interpolate(&values, &[true; 30]).unwrap();
        // The definition, solved and summed for single pixels.
        let spline = ThinPlate::new(&points(), 26.0, SIZE);
        let right = DMatrix::from_fn(33, 1, |row, _| values.get(row).map_or(0.0, |value| value[0]));
        let weights = spline.system(&[true; 30]).lu().solve(&right).unwrap();
        for (x, y) in [(3, 2), (70, 61), (57, 44), (101, 90), (149, 129), (34, 38)] {
            let place = [x as f64, y as f64];
            let bend: f64 =
                points().iter().enumerate().map(|(i, &point)| weights[i] * radial(place, point, 26.0)).sum();
            let plane: f64 = spline.plane(place).iter().zip(weights.iter().skip(30)).map(|(a, b)| a * b).sum();
            let found = f64::from(u.at(x, y));
            assert!((found - bend - plane).abs() < 0.01, "{found} px instead of {} px at {x} {y}", bend + plane);
        }
    }

    #[test]
    fn points_on_a_line_give_no_field() {
        let in_use: Vec<bool> = (0..30).map(|point| point < 6).collect();
        assert!(interpolate(&[[0.0; 2]; 30], &in_use).is_none());
    }
}

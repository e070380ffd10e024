//! A body given by heights on a grid, as a smooth surface.

use fingervision_elastic::ReliefPoint;

use super::grid::HeightGrid;

/// A cubic B-spline whose control points are the heights of a grid.
///
/// Slopes are limited first, then edges are rounded, then the lowest height is made 0. The rounding is a normal
/// distribution as wide as the fillet of a flat face (the same standard deviation along the edge's normal); the spline's
/// own smoothing counts as part of it. Neither makes a slope steeper, so the surface stays within the limit, except for
/// the effect of the grid's step (below 1 %).
#[derive(Debug, Clone)]
pub(super) struct HeightField {
    grid: HeightGrid,
    /// Cosine and sine of the rotation of the body.
    turn: [f64; 2],
}

impl HeightField {
    /// The surface over a grid that holds a finite height somewhere.
    pub(super) fn new(mut grid: HeightGrid, fillet_mm: f64, wall_slope: f64, rotation_rad: f64) -> Self {
        grid.limit_slope(wall_slope);
        let width = fillet_mm * wall_slope / wall_slope.hypot(1.0);
        let (asked, own) = (width * width / 12.0, grid.step_mm * grid.step_mm / 3.0);
        grid.smooth((asked - own).max(0.0).sqrt());
        let (sin, cos) = rotation_rad.sin_cos();
        let mut field = Self { grid, turn: [cos, sin] };
        let lowest = field.nodes().map(|(_, height)| height).fold(f64::INFINITY, f64::min);
        for height in &mut field.grid.heights_mm {
            *height -= lowest;
        }
        field
    }

    /// Smallest and largest x and y of the nodes that lie at most `height_mm` behind the foremost point, mm, and a step
    /// more.
    pub(super) fn footprint_mm(&self, height_mm: f64) -> [[f64; 2]; 2] {
        let [cos, sin] = self.turn;
        let mut extent = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for ([x, y], _) in self.nodes().filter(|(_, height)| *height <= height_mm) {
            for ([low, high], value) in extent.iter_mut().zip([cos * x - sin * y, sin * x + cos * y]) {
                (*low, *high) = (low.min(value), high.max(value));
            }
        }
        extent.map(|[low, high]| [low - self.grid.step_mm, high + self.grid.step_mm])
    }

    pub(super) fn at(&self, point: [f64; 2]) -> ReliefPoint {
        let [cos, sin] = self.turn;
        let [x, y] = point;
        let own = self.within([cos * x + sin * y, cos * y - sin * x]);
        let [gx, gy] = own.slope;
        let [xx, xy, yy] = own.curvature_per_mm;
        let slope = [cos * gx - sin * gy, sin * gx + cos * gy];
        let curvature_per_mm = [
            cos * cos * xx - 2.0 * sin * cos * xy + sin * sin * yy,
            sin * cos * (xx - yy) + (cos * cos - sin * sin) * xy,
            sin * sin * xx + 2.0 * sin * cos * xy + cos * cos * yy,
        ];
        ReliefPoint { height_mm: own.height_mm, slope, curvature_per_mm }
    }

    /// Every inner node's place and height on the surface.
    fn nodes(&self) -> impl Iterator<Item = ([f64; 2], f64)> {
        let HeightGrid { columns, rows, .. } = self.grid;
        let inner = (1..rows - 1).flat_map(move |row| (1..columns - 1).map(move |column| (column, row)));
        inner.map(|(column, row)| {
            let weights = [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0];
            let of_row = |row: usize| (0..3).map(|n| weights[n] * self.height(column + n - 1, row)).sum::<f64>();
            (self.grid.node_mm(column, row), (0..3).map(|n| weights[n] * of_row(row + n - 1)).sum())
        })
    }

    fn height(&self, column: usize, row: usize) -> f64 {
        self.grid.heights_mm[row * self.grid.columns + column]
    }

    /// The surface in the grid's own directions. Beyond the grid the height is that at its edge, several mm behind
    /// everything that a press reaches.
    fn within(&self, point: [f64; 2]) -> ReliefPoint {
        let corner = self.grid.corner_mm();
        let places = [0, 1].map(|axis| (point[axis] - corner[axis]) / self.grid.step_mm);
        let ends = [self.grid.columns, self.grid.rows].map(|count| (count - 2) as f64);
        let held = [0, 1].map(|axis| places[axis].clamp(1.0, ends[axis]));
        let mut here = self.spline(held);
        for axis in (0..2).filter(|&axis| !(1.0..=ends[axis]).contains(&places[axis])) {
            here.slope[axis] = 0.0;
            here.curvature_per_mm[1] = 0.0;
            here.curvature_per_mm[2 * axis] = 0.0;
        }
        here
    }

    /// The spline at a position in units of nodes.
    fn spline(&self, place: [f64; 2]) -> ReliefPoint {
        let last = [self.grid.columns, self.grid.rows].map(|count| (count - 3) as f64);
        let first = [0, 1].map(|axis| place[axis].floor().min(last[axis]));
        let [[x, dx, ddx], [y, dy, ddy]] = [0, 1].map(|axis| weights(place[axis] - first[axis]));
        let [column, row] = first.map(|first| first as usize - 1);
        let (mut height, mut slope, mut bend) = (0.0, [0.0; 2], [0.0; 3]);
        for n in 0..4 {
            let line: [f64; 4] = [0, 1, 2, 3].map(|m| self.height(column + m, row + n));
            let sum = |weights: &[f64; 4]| (0..4).map(|m| weights[m] * line[m]).sum::<f64>();
            let [level, rise, turn] = [sum(&x), sum(&dx), sum(&ddx)];
            height += y[n] * level;
            slope = [slope[0] + y[n] * rise, slope[1] + dy[n] * level];
            bend = [bend[0] + y[n] * turn, bend[1] + dy[n] * rise, bend[2] + ddy[n] * level];
        }
        let per_mm = 1.0 / self.grid.step_mm;
        ReliefPoint {
            height_mm: height,
            slope: slope.map(|value| value * per_mm),
            curvature_per_mm: bend.map(|value| value * per_mm * per_mm),
        }
    }
}

/// Weights of four control points at a fraction between the second and the third, their first and second derivatives.
fn weights(t: f64) -> [[f64; 4]; 3] {
    let u = 1.0 - t;
    let inner = |t: f64, u: f64| (4.0 - 3.0 * t * t * (1.0 + u)) / 6.0;
    [
        [u * u * u / 6.0, inner(t, u), inner(u, t), t * t * t / 6.0],
        [-u * u / 2.0, t * (3.0 * t - 4.0) / 2.0, -u * (3.0 * u - 4.0) / 2.0, t * t / 2.0],
        [u, 3.0 * t - 2.0, 3.0 * u - 2.0, t],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::indenter::tests::assert_derivatives;

    fn wavy(rotation_rad: f64) -> HeightField {
        let mut grid = HeightGrid::around([3.0, 2.0], 0.3, 3.0);
        let is_body = |[x, y]: [f64; 2]| x.abs() <= 3.0 && y.abs() <= 2.0;
        grid.fill(|[x, y]| if is_body([x, y]) { 1.0 + 0.5 * x.sin() + 0.3 * (2.0 * y).cos() } else { f64::INFINITY });
        HeightField::new(grid, 0.3, 3.0, rotation_rad)
    }

    #[test]
    fn weights_are_those_of_a_cubic_spline() {
        for t in [0.0, 0.3, 0.77, 1.0] {
            let [value, first, second] = weights(t);
            let places = [-1.0, 0.0, 1.0, 2.0];
            // Sum, first and second moment of the control points: 1, t, t² + 1/3.
            let moment = |weights: [f64; 4], power: i32| (0..4).map(|n| weights[n] * f64::powi(places[n], power)).sum();
            let expected = [[1.0, t, t * t + 1.0 / 3.0], [0.0, 1.0, 2.0 * t], [0.0, 0.0, 2.0]];
            for (weights, expected) in [value, first, second].into_iter().zip(expected) {
                for (power, expected) in (0..).zip(expected) {
                    let sum: f64 = moment(weights, power);
                    assert!((sum - expected).abs() < 1e-14, "t {t}, power {power}: {sum} instead of {expected}");
                }
            }
        }
    }

    #[test]
    fn derivatives_agree_with_differences_turned_or_not() {
        for rotation_rad in [0.0, 0.7] {
            let field = wavy(rotation_rad);
            for n in 0..200 {
                let point = [0.618_034, 0.754_878].map(|step| 7.0 * ((f64::from(n) * step).fract() - 0.5));
                assert_derivatives(|[x, y]| field.at([x, y]), point, 1e-5);
            }
        }
    }

    #[test]
    fn beyond_the_grid_the_height_stays() {
        let field = wavy(0.0);
        let [left, top] = field.grid.corner_mm().map(|corner| corner + field.grid.step_mm);
        for ([x, y], [beyond_x, beyond_y]) in
            [([left, 0.3], [1.0, 0.0]), ([0.2, top], [0.0, 1.0]), ([left, top], [1.0; 2])]
        {
            let (edge, beyond) = (field.at([x, y]), field.at([x - beyond_x, y - beyond_y]));
            assert!((beyond.height_mm - edge.height_mm).abs() < 1e-9 && edge.height_mm > 7.0, "{edge:?}, {beyond:?}");
        }
        for point in [[left - 1.0, 0.7], [0.9, 1.0 - top], [left - 2.0, top - 1.0]] {
            assert_derivatives(|[x, y]| field.at([x, y]), point, 1e-4);
        }
    }
}

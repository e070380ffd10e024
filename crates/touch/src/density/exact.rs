//! The density by its definition: Gaussians summed pair by pair in `f64`.

use fingervision_flow::FlowField;
use fingervision_image::Image;

/// A Gaussian is cut at this many standard deviations: the rest has 4e-6 of the whole weight.
const CUT: f64 = 5.0;

/// The moved points of a flow, sorted into square cells as wide as the Gaussian reaches.
pub(super) struct MovedPoints {
    sigma: f64,
    columns: usize,
    rows: usize,
    cells: Vec<Vec<[f64; 2]>>,
}

impl MovedPoints {
    /// Moves every reference pixel by its flow. Points out of reach of the image and points that are not finite are left
    /// out.
    /// left out.
    pub(super) fn new(flow: &FlowField, sigma: f64) -> Self {
        let (width, height) = flow.size();
        let cells_along = |length: usize| (length as f64 / (CUT * sigma)).ceil() as usize + 2;
        let (columns, rows) = (cells_along(width), cells_along(height));
        let mut points = Self { sigma, columns, rows, cells: vec![Vec::new(); columns * rows] };
        for y in 0..height {
            for x in 0..width {
                let point = [x as f64 + f64::from(flow.u.at(x, y)), y as f64 + f64::from(flow.v.at(x, y))];
                if let Some((column, row)) = points.cell(point) {
                    points.cells[row * columns + column].push(point);
                }
            }
        }
        points
    }

    /// Column and row of the cell that holds a place; one ring of cells lies around the image.
    fn cell(&self, place: [f64; 2]) -> Option<(usize, usize)> {
        let [column, row] = place.map(|value| (value / (CUT * self.sigma)).floor() + 1.0);
        let is_inside = column >= 0.0 && row >= 0.0 && column < self.columns as f64 && row < self.rows as f64;
        is_inside.then_some((column as usize, row as usize))
    }

    /// `D(y) = 1/(2πσ²) Σ exp(−|y − x'|² / 2σ²)` over the moved points `x'`, dimensionless; 0 out of reach.
    pub(super) fn density_at(&self, place: [f64; 2]) -> f64 {
        let Some((column, row)) = self.cell(place) else { return 0.0 };
        let (left, right) = (column.saturating_sub(1), (column + 2).min(self.columns));
        let variance = self.sigma * self.sigma;
        let mut sum = 0.0;
        for row in row.saturating_sub(1)..(row + 2).min(self.rows) {
            for point in self.cells[row * self.columns + left..row * self.columns + right].iter().flatten() {
                let squared = (point[0] - place[0]).powi(2) + (point[1] - place[1]).powi(2);
                if squared <= CUT * CUT * variance {
                    sum += (-0.5 * squared / variance).exp();
                }
            }
        }
        sum / (std::f64::consts::TAU * variance)
    }
}

/// Writes the density at the moved place of every reference pixel.
pub(super) fn at_points_into(flow: &FlowField, sigma: f64, density: &mut Image<f32>) {
    let points = MovedPoints::new(flow, sigma);
    let (u, v) = (flow.u.rows(), flow.v.rows());
    for (y, ((density, u), v)) in density.rows_mut().zip(u).zip(v).enumerate() {
        for (x, density) in density.iter_mut().enumerate() {
            let place = [x as f64 + f64::from(u[x]), y as f64 + f64::from(v[x])];
            *density = points.density_at(place) as f32;
        }
    }
}

/// Writes the density at every pixel of the current image.
pub(super) fn at_pixels_into(flow: &FlowField, sigma: f64, density: &mut Image<f32>) {
    let points = MovedPoints::new(flow, sigma);
    for (y, density) in density.rows_mut().enumerate() {
        for (x, density) in density.iter_mut().enumerate() {
            *density = points.density_at([x as f64, y as f64]) as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_change_nothing() {
        let flow = FlowField {
            u: Image::from_fn(29, 23, |x, y| 9.0 * (0.4 * x as f32 + 0.2 * y as f32).sin()),
            v: Image::from_fn(29, 23, |x, y| 9.0 * (0.3 * x as f32 - 0.5 * y as f32).cos()),
        };
        let points = MovedPoints::new(&flow, 2.0);
        for place in [[0.0, 0.0], [28.4, 22.4], [13.7, 9.99], [10.0, 20.0], [-0.5, 5.0]] {
            let gaussians = (0..29 * 23).map(|i| {
                let (x, y) = (i % 29, i / 29);
                let dx = x as f64 + f64::from(flow.u.at(x, y)) - place[0];
                let dy = y as f64 + f64::from(flow.v.at(x, y)) - place[1];
                (-(dx * dx + dy * dy) / 8.0).exp() / (8.0 * std::f64::consts::PI)
            });
            let (cells, all) = (points.density_at(place), gaussians.sum::<f64>());
            assert!((cells - all).abs() < 1e-5, "at {place:?}: {cells} in cells, {all} over all");
        }
    }
}

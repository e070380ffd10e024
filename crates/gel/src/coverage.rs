//! Exact area coverage of the cells of a grid by a pixel, or a part of one.
//!
//! A pixel's four corners, mapped back to the pattern, span a quadrilateral there. Cutting it at the grid lines gives
//! one polygon per cell; the pixel is the mean of the cells' colours weighted by the polygons' areas. Nothing is
//! sampled. The sides are straight, so a curved motion causes an error: the deviation of the curve from a straight line
//! over one pixel.

use crate::cells::Cells;
use crate::polygon::{Point, cut, signed_area};
use fingervision_image::Image;

/// Mean colour of every quadrilateral of a grid of corners; the result has one column and row less.
pub(crate) fn mean_colours(corners: &Image<Point>, pattern: &impl Cells) -> Image<[f32; 3]> {
    let mut cutter = Cutter::default();
    Image::from_fn(corners.width() - 1, corners.height() - 1, |x, y| {
        let (above, below) = (corners.row(y), corners.row(y + 1));
        cutter.mean_colour([above[x], above[x + 1], below[x + 1], below[x]], pattern)
    })
}

/// Cuts polygons at grid lines; owns the memory for them.
#[derive(Default)]
struct Cutter {
    rest: Vec<Point>,
    strip: Vec<Point>,
    piece: Vec<Point>,
    beyond: Vec<Point>,
}

impl Cutter {
    fn mean_colour(&mut self, quad: [Point; 4], pattern: &impl Cells) -> [f32; 3] {
        let [columns, rows] = [0, 1].map(|axis| cell_range(quad, axis));
        if columns.0 == columns.1 && rows.0 == rows.1 {
            return pattern.at(columns.0, rows.0);
        }
        let mut total = [0.0; 3];
        let mut area = 0.0;
        self.rest.clear();
        self.rest.extend(quad);
        for column in columns.0..=columns.1 {
            cut(&self.rest, 0, (column + 1) as f64, &mut self.strip, &mut self.beyond);
            std::mem::swap(&mut self.rest, &mut self.beyond);
            for row in rows.0..=rows.1 {
                cut(&self.strip, 1, (row + 1) as f64, &mut self.piece, &mut self.beyond);
                std::mem::swap(&mut self.strip, &mut self.beyond);
                let piece = signed_area(&self.piece);
                area += piece;
                for (total, level) in total.iter_mut().zip(pattern.at(column, row)) {
                    *total += piece * f64::from(level);
                }
            }
        }
        total.map(|total| (total / area) as f32)
    }
}

/// First and last cell covered by the quadrilateral along an axis.
fn cell_range(quad: [Point; 4], axis: usize) -> (i64, i64) {
    let [a, b, c, d] = quad.map(|point| point[axis]);
    (a.min(b).min(c.min(d)).floor() as i64, a.max(b).max(c.max(d)).floor() as i64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ColourPattern;

    fn pattern() -> ColourPattern {
        ColourPattern::random(16, 16, [0, 255], 11).unwrap()
    }

    /// The definition: the mean over `count²` samples, exact as the count grows.
    fn sampled(quad: [Point; 4], count: u32, pattern: &ColourPattern) -> [f64; 3] {
        let mut total = [0.0; 3];
        let mut weights = 0.0;
        let share = |k: u32| (f64::from(k) + 0.5) / f64::from(count);
        for (s, t) in (0..count * count).map(|k| (share(k % count), share(k / count))) {
            let corner = |axis: usize| quad.map(|point| point[axis]);
            let place = [0, 1].map(|axis| {
                let [a, b, c, d] = corner(axis);
                (1.0 - t) * ((1.0 - s) * a + s * b) + t * ((1.0 - s) * d + s * c)
            });
            let [along_s, along_t] = [0, 1].map(|k| {
                [0, 1].map(|axis| {
                    let [a, b, c, d] = corner(axis);
                    if k == 0 { (1.0 - t) * (b - a) + t * (c - d) } else { (1.0 - s) * (d - a) + s * (c - b) }
                })
            });
            let weight = along_s[0] * along_t[1] - along_s[1] * along_t[0];
            weights += weight;
            for (total, level) in total.iter_mut().zip(pattern.at(place[0].floor() as i64, place[1].floor() as i64)) {
                *total += weight * f64::from(level);
            }
        }
        total.map(|total| total / weights)
    }

    #[test]
    fn the_mean_is_the_limit_of_dense_sampling() {
        let pattern = pattern();
        let corners = Image::from_fn(41, 31, |x, y| {
            let (x, y) = (x as f64, y as f64);
            [0.27 * x - 0.03 * y - 3.3 + 0.2 * (0.4 * y).sin(), 0.05 * x + 0.31 * y - 2.1 + 0.2 * (0.3 * x).cos()]
        });
        let means = mean_colours(&corners, &pattern);
        for (x, y) in (0..40).flat_map(|x| (0..30).map(move |y| (x, y))) {
            let (above, below) = (corners.row(y), corners.row(y + 1));
            let expected = sampled([above[x], above[x + 1], below[x + 1], below[x]], 64, &pattern);
            for (mean, expected) in means.at(x, y).iter().zip(expected) {
                // An edge displaces at most half a sample a row: 255 · ½ / 64 levels, and two edges may meet.
                assert!((f64::from(*mean) - expected).abs() < 3.0, "({x}, {y}): {mean}, sampled {expected}");
            }
        }
    }

    #[test]
    fn a_quad_wider_than_cells_sees_all_of_them() {
        let pattern = pattern();
        let quad = [[0.3, 0.2], [3.9, -0.1], [4.4, 3.7], [-0.2, 4.1]];
        let mean = Cutter::default().mean_colour(quad, &pattern);
        for (mean, expected) in mean.iter().zip(sampled(quad, 512, &pattern)) {
            assert!((f64::from(*mean) - expected).abs() < 0.2, "{mean}, sampled {expected}");
        }
    }

    #[test]
    fn an_upright_pixel_mixes_by_its_shares() {
        let pattern = pattern();
        // Cells of 4 px, shifted right by 0.3 px and down by 0.75 px.
        let corners = Image::from_fn(9, 9, |x, y| [(x as f64 - 0.3) / 4.0, (y as f64 - 0.75) / 4.0]);
        let means = mean_colours(&corners, &pattern);
        // Pixel 4 is [3.7, 4.7] across and [3.25, 4.25] down: it sees 0.3 of column 0 and 0.75 of row 0.
        for channel in 0..3 {
            let level = |column, row| f64::from(pattern.at(column, row)[channel]);
            let row = |row| 0.3 * level(0, row) + 0.7 * level(1, row);
            let expected = 0.75 * row(0) + 0.25 * row(1);
            assert!((f64::from(means.at(4, 4)[channel]) - expected).abs() < 1e-4);
        }
        assert_eq!(means.at(2, 2).map(f32::to_bits), pattern.at(0, 0).map(f32::to_bits));
    }
}

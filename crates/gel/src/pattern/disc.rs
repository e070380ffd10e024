//! Discs and the part of every cell of a raster that they cover, exactly.

use fingervision_image::Image;

/// A filled circle on the pattern, mm from its upper left corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Disc {
    pub(crate) centre_mm: [f64; 2],
    pub(crate) radius_mm: f64,
}

/// The uncovered part of every cell of an area with discs: 1 if not covered, 0 if fully covered.
///
/// A disc's share of a cell is exact. If two overlapping discs both cover only a part of a cell, their shares are treated
/// as independent.
#[derive(Debug, Clone)]
pub(crate) struct Ground {
    light: Image<f64>,
    cell_mm: [f64; 2],
    total: f64,
}

impl Ground {
    /// An empty area with this many columns and rows over a pattern of this size.
    pub(crate) fn bare([columns, rows]: [usize; 2], size_mm: [f64; 2]) -> Self {
        let cell_mm = [size_mm[0] / columns as f64, size_mm[1] / rows as f64];
        Self { light: Image::filled(columns, rows, 1.0), cell_mm, total: (columns * rows) as f64 }
    }

    /// The covered part of the area, 0 to 1.
    pub(crate) fn covered(&self) -> f64 {
        1.0 - self.total / self.light.values().len() as f64
    }

    pub(crate) fn cell_mm(&self) -> [f64; 2] {
        self.cell_mm
    }

    /// Adds a disc; the part beyond a border is lost.
    pub(crate) fn lay(&mut self, disc: Disc) {
        let (columns, rows) = self.light.size();
        let [first, last] = [-1.0, 1.0]
            .map(|sign| [0, 1].map(|axis| (disc.centre_mm[axis] + sign * disc.radius_mm) / self.cell_mm[axis]));
        let cells = |axis: usize, count: usize| {
            first[axis].max(0.0) as usize..(last[axis].floor() + 1.0).clamp(0.0, count as f64) as usize
        };
        for row in cells(1, rows) {
            let line = self.light.row_mut(row);
            for column in cells(0, columns) {
                let corner = [column as f64 * self.cell_mm[0], row as f64 * self.cell_mm[1]];
                let share = disc.share_of(corner, self.cell_mm);
                self.total -= line[column] * share;
                line[column] *= 1.0 - share;
            }
        }
    }

    /// The raster in grey: `dark` where discs lie, `bright` where none does.
    pub(crate) fn grey(&self, dark: f64, bright: f64) -> Image<f32> {
        let (columns, rows) = self.light.size();
        Image::from_fn(columns, rows, |x, y| (dark + (bright - dark) * self.light.at(x, y)) as f32)
    }
}

impl Disc {
    /// The disc and those of its copies on a torus of this size that reach into it.
    pub(crate) fn copies(self, size_mm: [f64; 2]) -> impl Iterator<Item = Self> {
        (0..9).filter_map(move |k| {
            let steps = [f64::from(k % 3 - 1), f64::from(k / 3 - 1)];
            let centre_mm = [0, 1].map(|axis| self.centre_mm[axis] + steps[axis] * size_mm[axis]);
            let reaches = |axis: usize| (-self.radius_mm..size_mm[axis] + self.radius_mm).contains(&centre_mm[axis]);
            (reaches(0) && reaches(1)).then_some(Self { centre_mm, ..self })
        })
    }

    /// Part of the rectangle with this upper left corner and size that the disc covers, 0 to 1.
    fn share_of(&self, [left, top]: [f64; 2], [width, height]: [f64; 2]) -> f64 {
        let [x, y] = [left - self.centre_mm[0], top - self.centre_mm[1]];
        let corners = [[x, y], [x + width, y], [x + width, y + height], [x, y + height]];
        let area: f64 = (0..4).map(|k| self.area_under(corners[k], corners[(k + 1) % 4])).sum();
        (area / (width * height)).clamp(0.0, 1.0)
    }

    /// Signed area of the part of the disc in the triangle of its centre and the edge from `p` to `q`, both relative to
    /// the centre, mm².
    fn area_under(&self, p: [f64; 2], q: [f64; 2]) -> f64 {
        let radius_squared = self.radius_mm * self.radius_mm;
        let sector = |a: [f64; 2], b: [f64; 2]| 0.5 * radius_squared * cross(a, b).atan2(dot(a, b));
        let along = [q[0] - p[0], q[1] - p[1]];
        // |p + t along|² = r² has the roots −middle ± half.
        let length_squared = dot(along, along);
        let middle = dot(p, along) / length_squared;
        let discriminant = middle * middle - (dot(p, p) - radius_squared) / length_squared;
        if discriminant <= 0.0 {
            return sector(p, q);
        }
        let half = discriminant.sqrt();
        let (enter, leave) = ((-middle - half).max(0.0), (-middle + half).min(1.0));
        if enter >= leave {
            return sector(p, q);
        }
        let at = |t: f64| [p[0] + t * along[0], p[1] + t * along[1]];
        let (a, b) = (at(enter), at(leave));
        sector(p, a) + 0.5 * cross(a, b) + sector(b, q)
    }
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    const DISC: Disc = Disc { centre_mm: [0.4, 0.3], radius_mm: 0.25 };

    #[test]
    fn shares_add_up_to_the_disc() {
        let mut ground = Ground::bare([37, 29], [1.0, 0.8]);
        ground.lay(DISC);
        let expected = PI * 0.0625 / 0.8;
        assert!((ground.covered() - expected).abs() < 1e-13, "{} against {expected}", ground.covered());
    }

    #[test]
    fn a_disc_over_a_corner_covers_the_other_three_too() {
        let mut ground = Ground::bare([20, 20], [1.0, 1.0]);
        Disc { centre_mm: [0.0, 0.0], radius_mm: 0.3 }.copies([1.0, 1.0]).for_each(|disc| ground.lay(disc));
        let grey = ground.grey(0.0, 1.0);
        for (x, y) in [(0, 0), (19, 0), (0, 19), (19, 19)] {
            assert!(grey.at(x, y) < 1e-6, "({x}, {y}): {}", grey.at(x, y));
        }
        assert!((ground.covered() - PI * 0.09).abs() < 1e-13);
    }

    #[test]
    fn a_share_is_the_limit_of_dense_sampling() {
        let count = 400;
        for (corner, size) in [([0.5, 0.3], [0.2, 0.1]), ([0.1, 0.0], [0.7, 0.2]), ([0.35, 0.1], [0.01, 0.9])] {
            let inside = |k: i32| {
                let at = |axis: usize, k: i32| corner[axis] + size[axis] * (f64::from(k) + 0.5) / f64::from(count);
                let place = [at(0, k % count) - DISC.centre_mm[0], at(1, k / count) - DISC.centre_mm[1]];
                dot(place, place) < 0.0625
            };
            let sampled = (0..count * count).filter(|&k| inside(k)).count() as f64 / f64::from(count * count);
            let share = DISC.share_of(corner, size);
            assert!((share - sampled).abs() < 2e-3, "{corner:?}: {share}, sampled {sampled}");
        }
    }
}

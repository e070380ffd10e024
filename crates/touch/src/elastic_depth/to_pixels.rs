//! Interpolates the values of the cells to the pixels, linear between the centres of the cells.
//!
//! Pixels that follow each other in a row mostly lie between the same four cells. They are processed together, as the lanes of
//! one register.

use fearless_simd::{Level, dispatch, f32x4, f32x8, prelude::*};
use fearless_simd_macros::simd;
use fingervision_elastic::SurfaceGrid;
use fingervision_flow::Team;

use super::pixel_sums::NOWHERE;

/// Most pixels of a run between four cells.
const LANES: usize = 8;

/// A byte for each of eight bits, the lowest first.
const BYTES: [[u8; LANES]; 1 << LANES] = {
    let mut bytes = [[0; LANES]; 1 << LANES];
    let mut at = 0;
    while at < LANES << LANES {
        let (bits, lane) = (at / LANES, at % LANES);
        bytes[bits][lane] = (bits >> lane) as u8 & 1;
        at += 1;
    }
    bytes
};

/// What is known of a cell: its depth, mm, the deviation of the depth, mm, and the share of the cell in contact, 0 to 1; then 0, so
/// that a cell fills a register.
pub(super) type Known = [f32; 4];

/// The same of some pixels, row by row; in contact is a pixel with a share above ½.
pub(super) struct Planes<'a> {
    pub(super) depth_mm: &'a mut [f32],
    pub(super) deviation_mm: &'a mut [f32],
    pub(super) contact: &'a mut [u8],
}

/// Where the pixels of an image lie between the cells.
#[derive(Debug, Clone)]
pub(super) struct ToPixels {
    level: Level,
    /// Cells in a row.
    columns: usize,
    /// The upper and the lower half of the image, which two threads can process.
    halves: [Part; 2],
}

/// Some pixels.
#[derive(Debug, Clone)]
struct Part {
    runs: Vec<Run>,
    /// Distance of each pixel from the centre of its upper left cell to the right and down, 0 to 1; with as many zeros as lanes
    /// at the end.
    right: Vec<f32>,
    down: Vec<f32>,
}

/// Pixels that follow each other, all between the same four cells, or all beside the gel.
#[derive(Debug, Clone, Copy)]
struct Run {
    /// The upper left of the four cells; [`NOWHERE`] beside the gel.
    cell: u32,
    first: u32,
    length: u32,
}

impl ToPixels {
    /// For pixels at these places on the grid, in cells, integer at their centres; none for a pixel that does not show the gel.
    pub(super) fn new(level: Level, grid: SurfaceGrid, places: &[Option<[f64; 2]>]) -> Self {
        let (upper, lower) = places.split_at(places.len() / 2);
        Self { level, columns: grid.columns, halves: [upper, lower].map(|places| Part::new(grid, places)) }
    }

    /// Writes the values of all pixels. A pixel beside the gel has depth 0, an infinite deviation and no contact.
    ///
    /// # Panics
    ///
    /// If there are fewer cells than the grid has, or not as many pixels as there are places.
    pub(super) fn write(&self, team: &Team, cells: &[Known], Planes { depth_mm, deviation_mm, contact }: Planes<'_>) {
        let [upper, lower] = &self.halves;
        let middle = upper.len();
        let pixels = middle + lower.len();
        assert_eq!(
            (depth_mm.len(), deviation_mm.len(), contact.len()),
            (pixels, pixels, pixels),
            "pixels of the planes"
        );
        let (depth_mm, lower_depth_mm) = depth_mm.split_at_mut(middle);
        let (deviation_mm, lower_deviation_mm) = deviation_mm.split_at_mut(middle);
        let (contact, lower_contact) = contact.split_at_mut(middle);
        let lower_planes =
            Planes { depth_mm: lower_depth_mm, deviation_mm: lower_deviation_mm, contact: lower_contact };
        let write =
            |part: &Part, planes| dispatch!(self.level, simd => part.write(simd, (self.columns, cells), planes));
        team.join(|| write(upper, Planes { depth_mm, deviation_mm, contact }), || write(lower, lower_planes));
    }
}

impl Part {
    fn new(grid: SurfaceGrid, places: &[Option<[f64; 2]>]) -> Self {
        let split = |place: f64, count: usize| {
            let place = place.clamp(0.0, (count - 1) as f64);
            let whole = (place as usize).min(count - 2);
            (whole, (place - whole as f64) as f32)
        };
        let (mut cells, mut right, mut down) = (Vec::new(), Vec::new(), Vec::new());
        for place in places {
            let ((column, beside), (row, below)) =
                place.map_or(((0, 0.0), (0, 0.0)), |[x, y]| (split(x, grid.columns), split(y, grid.rows)));
            cells.push(if place.is_some() { (row * grid.columns + column) as u32 } else { NOWHERE });
            right.push(beside);
            down.push(below);
        }
        for plane in [&mut right, &mut down] {
            plane.extend([0.0; LANES]);
        }
        let (mut runs, mut first) = (Vec::new(), 0);
        for same in cells.chunk_by(|left, right| left == right) {
            for part in same.chunks(if same[0] == NOWHERE { same.len() } else { LANES }) {
                runs.push(Run { cell: part[0], first, length: part.len() as u32 });
                first += part.len() as u32;
            }
        }
        Self { runs, right, down }
    }

    /// Number of pixels.
    fn len(&self) -> usize {
        self.right.len() - LANES
    }

    #[simd]
    fn write<S: Simd>(&self, simd: S, (columns, cells): (usize, &[Known]), planes: Planes<'_>) {
        let count = self.len();
        let Planes { depth_mm, deviation_mm, contact } = planes;
        let (depth_mm, deviation_mm, contact) =
            (&mut depth_mm[..count], &mut deviation_mm[..count], &mut contact[..count]);
        // Of one length: the second one needs no check of its own.
        let (rights, downs) = (&self.right[..], &self.down[..self.right.len()]);
        for &Run { cell, first, length } in &self.runs {
            let (first, length) = (first as usize, length as usize);
            if cell == NOWHERE {
                depth_mm[first..first + length].fill(0.0);
                deviation_mm[first..first + length].fill(f32::INFINITY);
                contact[first..first + length].fill(0);
                continue;
            }
            let cells = &cells[cell as usize..][..columns + 2];
            let right = f32x8::from_slice(simd, &rights[first..first + LANES]);
            let down = f32x8::from_slice(simd, &downs[first..first + LANES]);
            // The value at the left and at the right of the cells is a + b down each.
            let [a, other_a] = [&cells[0], &cells[1]].map(|cell| f32x4::from_slice(simd, cell));
            let b = f32x4::from_slice(simd, &cells[columns]) - a;
            let other_b = f32x4::from_slice(simd, &cells[columns + 1]) - other_a;
            let terms = [a, b, other_a - a, other_b - b].map(f32x4::to_array);
            let mut values = [right; 3];
            for (k, value) in values.iter_mut().enumerate() {
                let [a, b, c, d] = terms.map(|term| f32x8::splat(simd, term[k]));
                *value = right.mul_add(down.mul_add(d, c), down.mul_add(b, a));
            }
            let [depth, deviation, share] = values;
            let touches = &BYTES[share.simd_gt(0.5).to_bitmask() as usize];
            // Lanes behind the run are written, too: they are those of the next one, which comes later.
            if first + LANES <= count {
                depth.store_slice(&mut depth_mm[first..][..LANES]);
                deviation.store_slice(&mut deviation_mm[first..][..LANES]);
                contact[first..][..LANES].copy_from_slice(touches);
            } else {
                depth_mm[first..][..length].copy_from_slice(&depth.as_slice()[..length]);
                deviation_mm[first..][..length].copy_from_slice(&deviation.as_slice()[..length]);
                contact[first..][..length].copy_from_slice(&touches[..length]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: SurfaceGrid = SurfaceGrid { columns: 9, rows: 7, cell_mm: 0.5 };
    const SIZE: (usize, usize) = (61, 43);

    /// A tilted view: cells are 5 to 8 px wide, and some pixels are beside the gel.
    fn places() -> Vec<Option<[f64; 2]>> {
        let place = |x: usize, y: usize| {
            let (x, y) = (x as f64, y as f64);
            let place = [0.15 * x + 0.01 * y - 0.8, 0.17 * y - 0.02 * x + 0.1];
            let is_on = |place: f64, count: usize| place >= -0.5 && place < count as f64 - 0.5;
            (is_on(place[0], GRID.columns) && is_on(place[1], GRID.rows)).then_some(place)
        };
        (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| place(x, y))).collect()
    }

    #[test]
    fn pixels_are_linear_between_the_centres_of_cells() {
        let places = places();
        let beside = places.iter().filter(|place| place.is_none()).count();
        assert!((100..SIZE.0 * SIZE.1 / 2).contains(&beside), "{beside} pixels beside the gel");
        let cells: Vec<Known> =
            (0..GRID.len()).map(|cell| [0, 1, 2, 3].map(|k| (3.7 * cell as f32 + k as f32).sin())).collect();
        let pixels = places.len();
        let write = |team: &Team| {
            let (mut depth_mm, mut deviation_mm, mut contact) = (vec![9.0; pixels], vec![9.0; pixels], vec![9; pixels]);
            let planes = Planes { depth_mm: &mut depth_mm, deviation_mm: &mut deviation_mm, contact: &mut contact };
            ToPixels::new(Level::new(), GRID, &places).write(team, &cells, planes);
            (depth_mm, deviation_mm, contact)
        };
        let found = write(&Team::default());
        assert!(write(&Team::new(2).unwrap()) == found, "with two threads");
        let (depth_mm, deviation_mm, contact) = found;
        for (pixel, place) in places.iter().enumerate() {
            let found = (depth_mm[pixel], deviation_mm[pixel], contact[pixel]);
            let Some(place) = place else {
                assert_eq!(found, (0.0, f32::INFINITY, 0), "pixel {pixel} is beside the gel");
                continue;
            };
            let [x, y] = [place[0].clamp(0.0, 8.0), place[1].clamp(0.0, 6.0)];
            let (column, row) = ((x as usize).min(7), (y as usize).min(5));
            let (right, down) = (x - column as f64, y - row as f64);
            let at = |k: usize, row: usize, column: usize| f64::from(cells[row * GRID.columns + column][k]);
            let along = |k: usize, row: usize| (1.0 - right) * at(k, row, column) + right * at(k, row, column + 1);
            let [depth, deviation, share] = [0, 1, 2].map(|k| (1.0 - down) * along(k, row) + down * along(k, row + 1));
            assert!((f64::from(found.0) - depth).abs() < 1e-5, "pixel {pixel}: {} against {depth}", found.0);
            assert!((f64::from(found.1) - deviation).abs() < 1e-5, "pixel {pixel}: {} against {deviation}", found.1);
            assert!((share - 0.5).abs() < 1e-5 || found.2 == u8::from(share > 0.5), "pixel {pixel}: {share}");
        }
    }
}

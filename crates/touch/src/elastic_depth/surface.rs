//! The gel's surface as cells, and the camera's measurement of each.
//!
//! A pixel at `x` with the flow `u` sees its point of the gel along the ray of `x + u`. With `X` the point at rest,
//! that ray meets the undeformed surface at `X + b`, the apparent displacement, and leans by the slope `a` from the z
//! axis. So the true displacement `(U, d)` satisfies two equations, exact and linear, one along x and one along y:
//!
//! ```text
//! U + a d = b
//! ```
//!
//! If the whole image has moved on the untouched gel, the place `x + u` is that before this motion.
//!
//! There are three unknowns for each point: the equations do not determine the depth d. Elasticity has to determine it.

use fearless_simd::Level;
use fingervision_elastic::{GelBlock, SurfaceGrid};
use fingervision_flow::{FlowField, Team};
use fingervision_image::Image;
use fingervision_optics::Camera;

use super::nearest::Nearest;
use super::pixel_sums::{CellPixels, NOWHERE, Pixels, Sum};
use super::rays::Rays;
use super::to_pixels::{Known, Planes, ToPixels};
use crate::whole_motion::WholeMotion;

/// If an invalid flow leads to a point nearer to the image's border than this, px, the gel there has left the field of
/// view.
const MARGIN_PX: f64 = 8.0;

/// The cells of a gel's surface, seen by a camera.
#[derive(Debug, Clone)]
pub(super) struct Surface {
    camera: Camera,
    pub(super) grid: SurfaceGrid,
    /// The cell of each pixel.
    cell_of: Vec<u32>,
    /// The pixels of each cell.
    pixels: CellPixels,
    to_pixels: ToPixels,
    /// The mean place of each cell's pixels in the reference image, px, and where that is on the gel, mm.
    rest: Vec<Option<Rest>>,
    /// Cells at the border of the visible part of the gel, where the gel continues.
    border: Vec<usize>,
    /// Width and height of the image, px.
    size: (usize, usize),
    /// Whether each cell is visible in the last frame, and the nearest visible cell.
    is_seen: Vec<bool>,
    nearest: Nearest,
    /// Sums over the pixels of each cell.
    sums: Vec<Sum>,
    team: Team,
    /// Size of a pixel on the undeformed surface, mm: the square root of the mean area that a pixel on the gel sees.
    pub(super) mm_per_px: f64,
    /// The motion of the whole image on the untouched gel, which is undone before anything is measured.
    pub(super) untouched_motion: WholeMotion,
    /// The measurements of the last frame, one for each cell.
    pub(super) seen: Vec<Seen>,
}

#[derive(Debug, Clone, Copy)]
struct Rest {
    px: [f64; 2],
    gel_mm: [f64; 2],
}

/// The camera's measurement of a cell.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Seen {
    /// b: the apparent displacement, mm.
    pub apparent_mm: [f32; 2],
    /// a: the slope of the ray, dimensionless.
    pub slope: [f32; 2],
    /// The part of the cell's pixels with valid flow, 0 to 1; 0 if no pixel shows the cell.
    pub trust: f32,
    /// Predicted standard deviation of its flow, both components together, on the undeformed surface, mm; 0 if no flow
    /// is valid.
    pub deviation_mm: f32,
}

/// The surface without drag, the displacement by shear and twist of contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WithoutDrag<'a> {
    /// The camera's measurements of the cells without drag.
    pub seen: &'a [Seen],
    /// Displacement of the cells that was subtracted, mm.
    pub dragged_mm: &'a [[f32; 3]],
    /// The part that it is of the displacement by drag, above 0, at most 1.
    pub part: f32,
}

impl Seen {
    /// Whether the flow is valid in most of the cell.
    pub(super) fn is_tracked(&self) -> bool {
        self.trust > 0.5
    }

    /// U = b − a d: the displacement along the surface, mm, of a cell at this depth, mm.
    #[must_use]
    pub fn lateral_mm(&self, depth_mm: f32) -> [f32; 2] {
        [0, 1].map(|axis| self.apparent_mm[axis] - self.slope[axis] * depth_mm)
    }
}

impl Surface {
    /// The surface of a gel in cells of `longest / cells`, for images of `size`; none if no pixel shows it.
    pub(super) fn new(camera: &Camera, gel: &GelBlock, size: (usize, usize), cells: usize) -> Option<Self> {
        let [width_mm, height_mm] = gel.size_mm;
        let cell_mm = width_mm.max(height_mm) / cells as f64;
        // Interpolation between cells needs two of them.
        let count = |length: f64| ((length / cell_mm).round() as usize).max(2);
        let grid = SurfaceGrid { columns: count(width_mm), rows: count(height_mm), cell_mm };
        let place = |x: usize, y: usize| {
            let [x_mm, y_mm] = camera.surface_point([x as f64, y as f64], 0.0)?;
            let place =
                [x_mm / cell_mm + 0.5 * (grid.columns as f64 - 1.0), y_mm / cell_mm + 0.5 * (grid.rows as f64 - 1.0)];
            let is_on = |place: f64, count: usize| place >= -0.5 && place < count as f64 - 0.5;
            (is_on(place[0], grid.columns) && is_on(place[1], grid.rows)).then_some(place)
        };
        let places: Vec<_> =
            (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y))).map(|(x, y)| place(x, y)).collect();
        let cell_of: Vec<_> = places
            .iter()
            .map(|place| {
                place.map_or(NOWHERE, |[x, y]| (y.round() as usize * grid.columns + x.round() as usize) as u32)
            })
            .collect();
        let rest = rest_of(camera, &cell_of, size.0, grid.len());
        let is_seen: Vec<_> = rest.iter().map(Option::is_some).collect();
        let mut nearest = Nearest::new((grid.columns, grid.rows));
        nearest.find(&is_seen);
        if !nearest.is_any() {
            return None;
        }
        let border = (0..grid.len()).filter(|&cell| !is_seen[cell]).filter_map(|cell| nearest.of(cell)).collect();
        let pixels = cell_of.iter().filter(|&&cell| cell != NOWHERE).count();
        let cells_seen = is_seen.iter().filter(|is_seen| **is_seen).count();
        Some(Self {
            camera: camera.clone(),
            grid,
            pixels: CellPixels::new(Level::new(), &cell_of, grid.len()),
            cell_of,
            to_pixels: ToPixels::new(Level::new(), grid, &places),
            border,
            size,
            is_seen,
            nearest,
            sums: vec![Sum::default(); grid.len()],
            team: Team::default(),
            mm_per_px: cell_mm * (cells_seen as f64 / pixels as f64).sqrt(),
            untouched_motion: WholeMotion::NONE,
            seen: vec![Seen::default(); grid.len()],
            rest,
        })
    }

    /// The rays of the pixels.
    pub(super) fn rays(&self) -> Rays {
        Rays::new(&self.camera, self.size)
    }

    /// Whether a pixel, counted row by row, shows the gel.
    pub(super) fn shows(&self, pixel: usize) -> bool {
        self.cell_of[pixel] != NOWHERE
    }

    /// Whether a pixel shows this cell at rest.
    pub(super) fn has_pixels(&self, cell: usize) -> bool {
        self.rest[cell].is_some()
    }

    /// From the camera to the undeformed surface, mm.
    pub(super) fn distance_mm(&self) -> f64 {
        self.camera.position_mm()[2]
    }

    /// Error of depth per error of the apparent displacement, mm per mm, for a point half-way from the gel's centre to
    /// its side: one over the slope of its ray.
    pub(super) fn typical_leverage(&self) -> f64 {
        let SurfaceGrid { columns, rows, cell_mm } = self.grid;
        self.distance_mm() / (0.25 * cell_mm * columns.max(rows) as f64)
    }

    /// The centre of a cell, mm.
    pub(super) fn centre_mm(&self, cell: usize) -> [f64; 2] {
        let SurfaceGrid { columns, rows, cell_mm } = self.grid;
        let at = |index: usize, count: usize| (index as f64 + 0.5 - 0.5 * count as f64) * cell_mm;
        [at(cell % columns, columns), at(cell / columns, rows)]
    }

    /// The largest apparent displacement of a cell with valid flow, mm.
    pub(super) fn largest_apparent_mm(&self) -> f64 {
        let trusted = self.seen.iter().filter(|seen| seen.is_tracked());
        let squares = trusted.map(|seen| seen.apparent_mm[0].powi(2) + seen.apparent_mm[1].powi(2));
        f64::from(squares.fold(0.0, f32::max)).sqrt()
    }

    /// The median deviation of the cells with valid flow, mm; `scratch` is memory to rank them.
    pub(super) fn typical_deviation_mm(&self, scratch: &mut Vec<f64>) -> f64 {
        scratch.clear();
        scratch.extend(self.seen.iter().filter(|seen| seen.is_tracked()).map(|seen| f64::from(seen.deviation_mm)));
        let middle = scratch.len() / 2;
        if scratch.is_empty() { 0.0 } else { *scratch.select_nth_unstable_by(middle, f64::total_cmp).1 }
    }

    /// Cells at the border of the visible part of the gel, where the gel continues.
    pub(super) fn border(&self) -> impl Iterator<Item = usize> {
        self.border.iter().copied()
    }

    /// Whether the camera sees a cell in the current frame.
    pub(super) fn is_seen(&self, cell: usize) -> bool {
        self.is_seen[cell]
    }

    /// Takes a frame's flow, px, its deviation, px, and its validity. Cells outside the field of view take the
    /// displacement of the nearest visible cell.
    pub(super) fn look(&mut self, flow: &FlowField, deviation: &Image<f32>, valid: &Image<u8>) {
        let (u, v) = (flow.u.values(), flow.v.values());
        let pixels = Pixels { u, v, deviation: deviation.values(), valid: valid.values() };
        let middle = self.sums.len() / 2;
        let (upper, lower) = self.sums.split_at_mut(middle);
        let cells = &self.pixels;
        self.team.join(|| cells.add_up(&pixels, 0, upper), || cells.add_up(&pixels, middle, lower));
        let [camera_x, camera_y, height] = self.camera.position_mm();
        let cells = self.seen.iter_mut().zip(&mut self.is_seen).zip(&self.sums).zip(&self.rest);
        let mut is_changed = false;
        for (((seen, is_seen), sum), rest) in cells {
            let Some(rest) = rest else { continue };
            let flow = sum.flow.map(|total| f64::from(total / sum.count.max(1.0)));
            let px = [rest.px[0] + flow[0], rest.px[1] + flow[1]];
            let now = self.camera.surface_point(self.untouched_motion.undo(px), 0.0);
            let [x, y] = now.unwrap_or(rest.gel_mm);
            *seen = Seen {
                apparent_mm: [(x - rest.gel_mm[0]) as f32, (y - rest.gel_mm[1]) as f32],
                slope: [((x - camera_x) / height) as f32, ((y - camera_y) / height) as f32],
                trust: if now.is_some() { sum.valid / sum.count.max(1.0) } else { 0.0 },
                deviation_mm: (sum.variance / sum.valid.max(1.0)).sqrt() * self.mm_per_px as f32,
            };
            let was_seen =
                std::mem::replace(is_seen, sum.count > 0.0 && (seen.trust >= 0.5 || is_within(self.size, px)));
            is_changed |= was_seen != *is_seen;
        }
        if is_changed {
            self.nearest.find(&self.is_seen);
        }
        self.fill();
    }

    /// Cells that are not visible take the measurement of the nearest visible cell.
    fn fill(&mut self) {
        for cell in (0..self.seen.len()).filter(|&cell| !self.is_seen[cell]) {
            if let Some(from) = self.nearest.of(cell) {
                self.seen[cell] = Seen { trust: 0.0, ..self.seen[from] };
            }
        }
    }

    /// Sets the threads that share the work.
    pub(super) fn share(&mut self, team: &Team) {
        self.team = team.clone();
    }

    /// Interpolates values of the cells to the pixels.
    pub(super) fn write_pixels(&self, cells: &[Known], planes: Planes<'_>) {
        self.to_pixels.write(&self.team, cells, planes);
    }

    /// The measurement of a cell at a depth, mm, after a displacement, mm, is subtracted from its own.
    pub(super) fn without(&self, cell: usize, depth_mm: f32, [x, y, z]: [f32; 3]) -> Seen {
        let seen = &self.seen[cell];
        let lateral_mm = seen.lateral_mm(depth_mm);
        let [camera_x, camera_y, height] = self.camera.position_mm();
        let rest = self.centre_mm(cell);
        let depth = f64::from(depth_mm - z);
        let beside = |axis: usize, camera: f64, taken: f32| {
            let moved = f64::from(lateral_mm[axis] - taken);
            let slope = (rest[axis] + moved - camera) / (height - depth);
            (moved + slope * depth, slope)
        };
        let [(apparent_x, slope_x), (apparent_y, slope_y)] = [beside(0, camera_x, x), beside(1, camera_y, y)];
        Seen {
            apparent_mm: [apparent_x as f32, apparent_y as f32],
            slope: [slope_x as f32, slope_y as f32],
            trust: seen.trust,
            deviation_mm: seen.deviation_mm,
        }
    }
}

/// The four neighbours of a cell; none at the grid's border.
pub(super) fn neighbours(grid: SurfaceGrid, cell: usize) -> Option<[usize; 4]> {
    let (column, row) = (cell % grid.columns, cell / grid.columns);
    let is_inner = column > 0 && row > 0 && column + 1 < grid.columns && row + 1 < grid.rows;
    is_inner.then(|| [cell - 1, cell + 1, cell - grid.columns, cell + grid.columns])
}

/// Mean place of each cell's pixels.
fn rest_of(camera: &Camera, cell_of: &[u32], width: usize, cells: usize) -> Vec<Option<Rest>> {
    let mut sums = vec![([0.0, 0.0], 0.0); cells];
    for (pixel, &cell) in cell_of.iter().enumerate() {
        if cell != NOWHERE {
            let (place, count) = &mut sums[cell as usize];
            place[0] += (pixel % width) as f64;
            place[1] += (pixel / width) as f64;
            *count += 1.0;
        }
    }
    let rest = |(place, count): ([f64; 2], f64)| {
        let px = place.map(|sum| sum / count);
        (count > 0.0).then(|| camera.surface_point(px, 0.0)).flatten().map(|gel_mm| Rest { px, gel_mm })
    };
    sums.into_iter().map(rest).collect()
}

/// Whether a place in the image is at least [`MARGIN_PX`] away from its border.
fn is_within((width, height): (usize, usize), px: [f64; 2]) -> bool {
    let is_inner = |at: f64, count: usize| at >= MARGIN_PX && at <= count as f64 - 1.0 - MARGIN_PX;
    is_inner(px[0], width) && is_inner(px[1], height)
}

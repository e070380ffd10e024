//! The shape of contact that sticks while it is dragged.
//!
//! Where the gel sticks to an object, it moves with it as a rigid body, whatever the object's shape: each point from its
//! position when the object began to move along the surface. The camera sees each point on a ray, so the fit of
//! [`super::rigid`] determines the motion, and with it every change of depth since then. The network does not know
//! this: it estimates depth anew in every frame, and under large shear its error is several times as large.
//!
//! Contact that slides moves differently and is left to the network; the shape is then forgotten. Gel that spreads evenly
//! under an object looks in the image as if it came closer. Therefore most of the motion along the surface has to be a translation
//! and a rotation, the depth must be about that of the network, and a part of the difference counts as uncertain.

#[cfg(test)]
mod tests;

use fingervision_elastic::SurfaceGrid;

use super::motion::Motion;
use super::rigid::{self, Positions, RigidMotion};
use super::surface::{self, Surface};
use super::thresholds::THRESHOLDS;

/// Least [sticking](Motion::sticking) of the motion since the frame of the shape.
const LEAST_STICKING: f64 = 0.5;
/// Least motion that shows that contact slid, root mean square, in thicknesses: smaller motion may be due to the error of depth.
const LEAST_SLIDING: f64 = 0.01;
/// Least part of the cells inside contact that belong to the shape; below it contact moved away.
const LEAST_COMMON: f64 = 0.2;
/// Range of the depth of the moved shape, relative to that which the network estimates from the whole motion. For balls that stick it
/// is 0.64 to 1.20 in either mode; gel that spreads while it is dragged looks 1.39 times as deep and more.
const RELATIVE_DEPTH: [f64; 2] = [0.55, 1.25];
/// The part of the difference between both depths that counts as uncertain.
const UNCERTAIN: f64 = 0.25;
/// Largest distance of cells that are touched by the same object from the box around its shape, cells.
const REACH: usize = 12;
/// Largest distance of cells from the shape, along rows and columns, cells, that keep the depth that they had beside it, too.
const BESIDE: usize = 4;
/// Frames without any estimate after which the shape is forgotten: contact may be another one.
const MOST_SKIPPED_FRAMES: u32 = 3;

/// Positions of the cells in contact and beside it, in the last frame in which it was pressed straight down.
#[derive(Debug)]
pub(super) struct StuckShape {
    is_known: bool,
    /// Whether contact moved in a way that the shape does not explain.
    has_slid: bool,
    skipped: u32,
    grid: SurfaceGrid,
    /// The first and the last column and row of the shape.
    columns_reached: [usize; 2],
    rows_reached: [usize; 2],
    touches: Vec<bool>,
    /// Whether the position of each cell is known: those in contact and those beside it.
    has_position: Vec<bool>,
    position_mm: Vec<[f32; 3]>,
    deviation_mm: Vec<f32>,
    inner: Vec<usize>,
}

/// Contact in the present frame: cells that are touched, cells inside of it, their depth as the network estimates it from the
/// whole motion, their depth and its deviation, mm.
#[derive(Debug)]
pub(super) struct Contact<'a> {
    pub(super) touches: &'a [bool],
    pub(super) inner: &'a [usize],
    pub(super) whole_mm: &'a [f32],
    pub(super) depth_mm: &'a mut [f32],
    pub(super) deviation_mm: &'a mut [f32],
}

impl Positions for StuckShape {
    fn position_mm(&self, _: &Surface, cell: usize) -> [f64; 3] {
        self.position_mm[cell].map(f64::from)
    }
}

impl StuckShape {
    /// None known, on a surface of these cells.
    pub(super) fn new(grid: SurfaceGrid) -> Self {
        let cells = grid.len();
        Self {
            is_known: false,
            has_slid: false,
            skipped: 0,
            grid,
            columns_reached: [0; 2],
            rows_reached: [0; 2],
            touches: vec![false; cells],
            has_position: vec![false; cells],
            position_mm: vec![[0.0; 3]; cells],
            deviation_mm: vec![0.0; cells],
            inner: Vec::with_capacity(cells),
        }
    }

    /// Forgets the shape.
    pub(super) fn forget(&mut self) {
        self.is_known = false;
    }

    /// Begins a frame with an estimate.
    pub(super) fn begin(&mut self) {
        (self.has_slid, self.skipped) = (false, 0);
    }

    /// Counts a frame without any estimate.
    pub(super) fn skip(&mut self) {
        self.skipped = self.skipped.saturating_add(1);
        if self.skipped >= MOST_SKIPPED_FRAMES {
            self.forget();
        }
    }

    /// Takes the shape of contact in a frame in which it is pressed straight down: the depth of every cell and its deviation, mm.
    pub(super) fn take(
        &mut self,
        surface: &Surface,
        touches: &[bool],
        depth_mm: &[f32],
        deviation_mm: impl Fn(usize) -> f32,
    ) {
        self.is_known = true;
        self.touches.copy_from_slice(touches);
        self.find_extent();
        for cell in (0..touches.len()).filter(|&cell| self.has_position[cell]) {
            let [x, y] = surface.centre_mm(cell).map(|at| at as f32);
            let [moved_x, moved_y] = surface.seen[cell].lateral_mm(depth_mm[cell]);
            self.position_mm[cell] = [x + moved_x, y + moved_y, depth_mm[cell]];
            self.deviation_mm[cell] = deviation_mm(cell);
        }
    }

    /// Finds the first and the last column and row of the shape, and the cells beside it.
    fn find_extent(&mut self) {
        (self.columns_reached, self.rows_reached) = ([usize::MAX, 0], [usize::MAX, 0]);
        self.has_position.fill(false);
        let SurfaceGrid { columns, rows, .. } = self.grid;
        for cell in (0..self.touches.len()).filter(|&cell| self.touches[cell]) {
            let (column, row) = (cell % columns, cell / columns);
            for (reached, at) in [(&mut self.columns_reached, column), (&mut self.rows_reached, row)] {
                *reached = [reached[0].min(at), reached[1].max(at)];
            }
            self.has_position[cell] = true;
            // Cells beside an inner one are beside one of the rim, too.
            if surface::neighbours(self.grid, cell).is_some_and(|near| near.iter().all(|&near| self.touches[near])) {
                continue;
            }
            let first = column.saturating_sub(BESIDE);
            let count = (column + BESIDE + 1).min(columns) - first;
            for row in row.saturating_sub(BESIDE)..(row + BESIDE + 1).min(rows) {
                self.has_position[row * columns + first..][..count].fill(true);
            }
        }
    }

    /// Whether a cell can be touched by the object that made the shape.
    fn reaches(&self, cell: usize) -> bool {
        let is_near = |at: usize, [first, last]: [usize; 2]| at + REACH >= first && at <= last + REACH;
        is_near(cell % self.grid.columns, self.columns_reached) && is_near(cell / self.grid.columns, self.rows_reached)
    }

    /// Forgets the shape if contact slid in the last frame, which is to be trusted.
    pub(super) fn forget_if_slid(&mut self) {
        if self.has_slid {
            self.forget();
        }
    }

    /// Gives contact the depth of the shape, moved as a rigid body, if most of it moves so. Cells beside the shape that are touched,
    /// too, keep the depth that they had then, moved in the same way: contact is seen better while it is dragged than before, and its
    /// rim is where the depth of the network is least certain. The depth of cells farther away that are touched by the same object
    /// changes in proportion. `noise_mm` is the error of the flow. Returns whether contact sticks.
    pub(super) fn hold(
        &mut self,
        surface: &Surface,
        contact: Contact<'_>,
        noise_mm: f64,
        thickness_mm: f64,
        scratch: &mut Vec<f64>,
    ) -> bool {
        let Some((motion, deviation_mm)) = self.motion(surface, &contact, noise_mm, thickness_mm, scratch) else {
            return false;
        };
        let Contact { touches, whole_mm, depth_mm, deviation_mm: deviations_mm, .. } = contact;
        let sticks = |cell: usize| rigid::distance_mm(surface, self, cell, &motion) < rigid::tolerance_mm(noise_mm);
        let by_shape_mm = |cell: usize| motion.moves(self.position_mm(surface, cell))[2];
        let (mut by_shape, mut by_network, mut by_whole, mut count) = (0.0, 0.0, 0.0, 0.0);
        for &cell in self.inner.iter().filter(|&&cell| sticks(cell)) {
            by_shape += by_shape_mm(cell);
            by_network += f64::from(depth_mm[cell]);
            by_whole += f64::from(whole_mm[cell]);
            count += 1.0;
        }
        let factor = by_shape / by_network;
        if !(RELATIVE_DEPTH[0]..=RELATIVE_DEPTH[1]).contains(&(by_shape / by_whole)) {
            return false;
        }
        let uncertain_mm = UNCERTAIN * (by_shape - by_network) / count;
        for cell in (0..depth_mm.len()).filter(|&cell| touches[cell] && self.reaches(cell)) {
            let in_proportion_mm = depth_mm[cell] * factor as f32;
            let moved_mm = if self.has_position[cell] { by_shape_mm(cell) as f32 } else { in_proportion_mm };
            if self.touches[cell] && sticks(cell) {
                let errors = [f64::from(self.deviation_mm[cell]), deviation_mm, uncertain_mm];
                deviations_mm[cell] = errors.iter().map(|error| error * error).sum::<f64>().sqrt() as f32;
            } else {
                let change_mm = (in_proportion_mm - depth_mm[cell]).abs().max((moved_mm - depth_mm[cell]).abs());
                deviations_mm[cell] = deviations_mm[cell].hypot(change_mm);
            }
            depth_mm[cell] = moved_mm;
        }
        true
    }

    /// The motion of contact since the frame of the shape and the deviation of the depth that it gives, mm, if most of contact
    /// sticks.
    fn motion(
        &mut self,
        surface: &Surface,
        contact: &Contact<'_>,
        noise_mm: f64,
        thickness_mm: f64,
        scratch: &mut Vec<f64>,
    ) -> Option<(RigidMotion, f64)> {
        if !self.is_known {
            return None;
        }
        self.inner.clear();
        self.inner.extend(contact.inner.iter().copied().filter(|&cell| self.touches[cell]));
        let near = contact.inner.iter().filter(|&&cell| self.reaches(cell)).count();
        // Contact that moved away from the shape slid; contact that only grew did not.
        self.has_slid = (self.inner.len() as f64) < LEAST_COMMON * contact.inner.len() as f64;
        let moved = self.inner.iter().map(|&cell| {
            let [x, y, _] = self.position_mm(surface, cell);
            let (rest, along) = (surface.centre_mm(cell), surface.seen[cell].lateral_mm(contact.depth_mm[cell]));
            let to = [0, 1].map(|axis| rest[axis] + f64::from(along[axis]));
            ([x, y], [to[0] - x, to[1] - y])
        });
        let moved = Motion::of(moved)?;
        if moved.sticking() < LEAST_STICKING {
            self.has_slid |= moved.whole_mm() > LEAST_SLIDING * thickness_mm;
            return None;
        }
        let found = rigid::fit(surface, self, &self.inner, noise_mm, scratch)?;
        self.has_slid |= !found.sticks(noise_mm);
        let matching = found.matching * self.inner.len() as f64 / near as f64;
        let deviation_mm = rigid::depth_deviation_mm(surface, self, &self.inner, &found, noise_mm)?;
        let is_certain = deviation_mm <= THRESHOLDS.most_face_deviation * thickness_mm;
        let is_most = matching >= THRESHOLDS.least_matching;
        (!self.has_slid && is_most && is_certain).then_some((found.motion, deviation_mm))
    }
}

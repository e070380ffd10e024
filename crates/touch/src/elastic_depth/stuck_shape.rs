//! The shape of contact that sticks while it is dragged.
//!
//! Where the gel sticks to an object, it moves with it as a rigid body, whatever the object's shape: each point from its
//! position when the object began to move along the surface. The camera sees each point on a ray, so the fit of
//! [`super::rigid`] determines the motion, and with it every change of depth since then. The network does not know
//! this: it estimates depth anew in every frame, and under large shear its error is several times as large.
//!
//! Contact that slides out from under the object moves differently and is left to the network. So is gel that only
//! spreads under a face, which in the image looks as if it came closer: at least most of the motion has to be a translation
//! and a rotation along the surface.

#[cfg(test)]
mod tests;

use super::motion::Motion;
use super::rigid::{self, Positions, RigidMotion};
use super::surface::Surface;
use super::thresholds::THRESHOLDS;

/// Least [sticking](Motion::sticking) of the motion since the shape was known.
const LEAST_STICKING: f64 = 0.5;

/// Positions of the cells in contact in the last frame without shear.
#[derive(Debug)]
pub(super) struct StuckShape {
    is_known: bool,
    touches: Vec<bool>,
    position_mm: Vec<[f32; 3]>,
    deviation_mm: Vec<f32>,
    inner: Vec<usize>,
}

/// The motion of contact since then.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moved {
    motion: RigidMotion,
    deviation_mm: f64,
    /// Largest distance of a cell that moves with the shape, mm.
    tolerance_mm: f64,
}

impl Positions for StuckShape {
    fn position_mm(&self, _: &Surface, cell: usize) -> [f64; 3] {
        self.position_mm[cell].map(f64::from)
    }
}

impl StuckShape {
    /// None known, on a surface of this many cells.
    pub(super) fn new(cells: usize) -> Self {
        Self {
            is_known: false,
            touches: vec![false; cells],
            position_mm: vec![[0.0; 3]; cells],
            deviation_mm: vec![0.0; cells],
            inner: Vec::with_capacity(cells),
        }
    }

    /// Forgets the shape.
    pub(super) fn forget(&mut self) {
        self.is_known = false;
    }

    /// Takes the shape of contact in a frame without shear: the depth of every cell and its deviation, mm.
    pub(super) fn take(
        &mut self,
        surface: &Surface,
        touches: &[bool],
        depth_mm: &[f32],
        deviation_mm: impl Fn(usize) -> f32,
    ) {
        self.is_known = true;
        self.touches.copy_from_slice(touches);
        for cell in (0..touches.len()).filter(|&cell| touches[cell]) {
            let [x, y] = surface.centre_mm(cell).map(|at| at as f32);
            let [moved_x, moved_y] = surface.seen[cell].lateral_mm(depth_mm[cell]);
            self.position_mm[cell] = [x + moved_x, y + moved_y, depth_mm[cell]];
            self.deviation_mm[cell] = deviation_mm(cell);
        }
    }

    /// The motion of contact since then, if it sticks: `inner` are cells inside contact, at these depths, mm, with this
    /// error of the flow, mm, on a gel of this thickness, mm.
    pub(super) fn motion(
        &mut self,
        surface: &Surface,
        (inner, depth_mm): (&[usize], &[f32]),
        noise_mm: f64,
        thickness_mm: f64,
        scratch: &mut Vec<f64>,
    ) -> Option<Moved> {
        if !self.is_known {
            return None;
        }
        self.inner.clear();
        self.inner.extend(inner.iter().copied().filter(|&cell| self.touches[cell]));
        let moved = self.inner.iter().map(|&cell| {
            let [x, y, _] = self.position_mm(surface, cell);
            let (rest, along) = (surface.centre_mm(cell), surface.seen[cell].lateral_mm(depth_mm[cell]));
            let to = [0, 1].map(|axis| rest[axis] + f64::from(along[axis]));
            ([x, y], [to[0] - x, to[1] - y])
        });
        if Motion::of(moved)?.sticking() < LEAST_STICKING {
            return None;
        }
        let found = rigid::fit(surface, self, &self.inner, noise_mm, scratch).filter(|found| found.sticks(noise_mm))?;
        let deviation_mm = rigid::depth_deviation_mm(surface, self, &self.inner, &found, noise_mm)?;
        let is_certain = deviation_mm <= THRESHOLDS.most_face_deviation * thickness_mm;
        let moved = Moved { motion: found.motion, deviation_mm, tolerance_mm: rigid::tolerance_mm(noise_mm) };
        is_certain.then_some(moved)
    }

    /// Depth of a cell after the motion and its deviation, mm, if the cell moved with the shape.
    pub(super) fn depth_mm(&self, surface: &Surface, cell: usize, moved: &Moved) -> Option<[f32; 2]> {
        let sticks = self.touches[cell] && rigid::distance_mm(surface, self, cell, &moved.motion) < moved.tolerance_mm;
        let depth_mm = moved.motion.moves(self.position_mm(surface, cell))[2];
        sticks.then(|| [depth_mm as f32, self.deviation_mm[cell].hypot(moved.deviation_mm as f32)])
    }
}

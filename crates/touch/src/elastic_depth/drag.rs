//! Separates the displacement caused by motion of contact along the surface from that of the indentation.
//!
//! At small strain displacements add up: a press that also shears or twists the gel moves it as the press alone would,
//! plus the displacement caused by the motion of contact along the surface. This motion, a translation and a rotation,
//! is visible. Elasticity gives the displacement of the whole surface, from tractions that cause this motion of contact
//! without changing its depth. What is left after subtracting it looks like a press straight down, but for what linear elasticity
//! neglects: the network estimates depth from it with weights of its own.

use fingervision_elastic::BlockOperator;

use super::coarse::CoarseGrid;
use super::contact::ContactFinder;
use super::motion::{Motion, ramp};
use super::surface::{Seen, Surface, WithoutDrag};
use super::traction::{Limits, Tractions};

/// Ratio of motion along the surface to depth, root mean squares: below the first number nothing is subtracted, above
/// the second the whole displacement. For faces pressed straight down it is below 0.02 if they stick, but up to 0.22 if they slide
/// tilted or at a corner of the gel.
const PARTIAL: [f64; 2] = [0.1, 0.2];

/// Finds the displacement caused by shear and twist in every frame.
#[derive(Debug)]
pub(super) struct Drag {
    coarse: CoarseGrid,
    limits: Limits,
    tractions: Tractions,
    touches: Vec<bool>,
    /// Motion of contact along the surface, mm.
    wanted_mm: Vec<[f32; 3]>,
    /// The part of that motion that is subtracted, 0 to 1.
    part: f32,
    /// Motion of contact along the surface relative to its depth, root mean squares.
    ratio: f64,
    /// That motion, root mean square, mm.
    moved_mm: f64,
    /// Displacement of the surface's cells by shear and twist alone, mm.
    dragged_mm: Vec<[f32; 3]>,
    /// The camera's measurements of the cells without shear and twist.
    seen: Vec<Seen>,
}

impl Drag {
    /// No motion yet, on a surface of this many cells; `operator` is the gel's compliance on the grid of `coarse`.
    pub(super) fn new(cells: usize, coarse: CoarseGrid, operator: BlockOperator, limits: Limits) -> Self {
        Self {
            limits,
            tractions: Tractions::new(operator),
            touches: vec![false; coarse.grid.len()],
            wanted_mm: vec![[0.0; 3]; coarse.grid.len()],
            coarse,
            part: 0.0,
            ratio: 0.0,
            moved_mm: 0.0,
            dragged_mm: vec![[0.0; 3]; cells],
            seen: vec![Seen::default(); cells],
        }
    }

    /// Forgets the previous frames.
    pub(super) fn rest(&mut self) {
        self.tractions.rest();
        (self.part, self.ratio, self.moved_mm) = (0.0, 0.0, 0.0);
    }

    /// Motion of contact along the surface relative to its depth, root mean squares; 0 without contact.
    pub(super) fn ratio(&self) -> f64 {
        self.ratio
    }

    /// Motion of contact along the surface, root mean square, mm; 0 without contact.
    pub(super) fn moved_mm(&self) -> f64 {
        self.moved_mm
    }

    /// The surface without drag, where there is any.
    pub(super) fn found(&self) -> Option<WithoutDrag<'_>> {
        let part = self.part;
        (part > 0.0).then_some(WithoutDrag { seen: &self.seen, dragged_mm: &self.dragged_mm, part })
    }

    /// Finds the motion of contact along the surface and the displacement it causes.
    pub(super) fn find(&mut self, surface: &Surface, contact: &ContactFinder) {
        let found = motion_of(surface, contact);
        (self.ratio, self.moved_mm) = found.as_ref().map_or((0.0, 0.0), |(ratio, motion)| (*ratio, motion.mean_mm()));
        self.part = 0.0;
        let Some((ratio, motion)) = found else { return };
        let part = ramp(ratio, PARTIAL);
        if part <= 0.0 {
            return;
        }
        self.part = part as f32;
        let centres = self.coarse.grid.centres_mm().zip(self.coarse.around());
        for ((centre_mm, around), (touches, wanted)) in centres.zip(self.touches.iter_mut().zip(&mut self.wanted_mm)) {
            let [x, y] = motion.moves(centre_mm).map(|moved| (part * moved) as f32);
            (*touches, *wanted) = (contact.touches_around(around), [x, y, 0.0]);
        }
        self.tractions.hold(&self.touches, &self.wanted_mm, self.limits);
        self.coarse.to_surface(self.tractions.displacement_mm(), &mut self.dragged_mm);
        for ((cell, seen), &dragged_mm) in self.seen.iter_mut().enumerate().zip(&self.dragged_mm) {
            *seen = surface.without(cell, contact.depth_mm[cell], dragged_mm);
        }
    }
}

/// Motion of contact along the surface, and before it its ratio to the depth; none without contact.
fn motion_of(surface: &Surface, contact: &ContactFinder) -> Option<(f64, Motion)> {
    let cells = || (0..surface.grid.len()).filter(|&cell| contact.touches[cell]);
    let lateral_mm = |cell: usize| surface.seen[cell].lateral_mm(contact.depth_mm[cell]).map(f64::from);
    let motion = Motion::of(cells().map(|cell| (surface.centre_mm(cell), lateral_mm(cell))))?;
    let depths: f64 = cells().map(|cell| f64::from(contact.depth_mm[cell]).powi(2)).sum();
    let ratio = if depths > 0.0 { (motion.square() / depths).sqrt() } else { 0.0 };
    Some((ratio, motion))
}

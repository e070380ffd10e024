//! What the gel does because it is dragged along its surface, set apart from what it does because it is pressed.
//!
//! Small strain adds up: a press that also shears or twists the gel moves it as the press alone would, plus what the motion of
//! contact along the surface does on its own. That motion, a shift and a turn, is seen; elasticity tells the rest of its field,
//! as the tractions that move contact so and keep its depth. Without it what is left looks like a press straight down, which
//! is what the network knows best.

use fingervision_elastic::BlockOperator;

use super::coarse::Coarse;
use super::contact::ContactFinder;
use super::surface::{Seen, Surface};
use super::traction::{Limits, Tractions};

/// Motion along the surface over depth, root mean squares: below the first number nothing is set apart, above the second all of
/// it. Faces that stick and are pressed straight down stay below 0.02, those that slide below 0.22.
const PARTIAL: [f64; 2] = [0.15, 0.3];
/// Which part of the squared motion in contact is a shift and a turn, in the same sense: contact that sticks reaches 0.97 and
/// more, contact that slides at most 0.945.
const PARTLY_STUCK: [f64; 2] = [0.945, 0.965];

/// Sets drag apart in every frame.
#[derive(Debug)]
pub(super) struct Drag {
    coarse: Coarse,
    limits: Limits,
    tractions: Tractions,
    touches: Vec<bool>,
    /// How contact is moved, mm.
    wanted_mm: Vec<[f32; 3]>,
    is_found: bool,
    /// Displacement of the surface's cells by drag alone, mm.
    dragged_mm: Vec<[f32; 3]>,
    /// What the camera would tell of the cells without drag.
    seen: Vec<Seen>,
}

/// A motion along the surface.
#[derive(Debug, Clone, Copy)]
struct Motion {
    centre_mm: [f64; 2],
    shift_mm: [f64; 2],
    turn: f64,
}

impl Drag {
    /// None yet, on a surface of so many cells; `operator` is the gel's compliance on the grid of `coarse`.
    pub(super) fn new(cells: usize, coarse: Coarse, operator: BlockOperator, limits: Limits) -> Self {
        Self {
            limits,
            tractions: Tractions::new(operator),
            touches: vec![false; coarse.grid.len()],
            wanted_mm: vec![[0.0; 3]; coarse.grid.len()],
            coarse,
            is_found: false,
            dragged_mm: vec![[0.0; 3]; cells],
            seen: vec![Seen::default(); cells],
        }
    }

    /// Forgets the frames before.
    pub(super) fn rest(&mut self) {
        self.tractions.rest();
        self.is_found = false;
    }

    /// What the camera would tell of the cells without drag, and their displacement by drag alone, mm, where there is any.
    pub(super) fn found(&self) -> Option<(&[Seen], &[[f32; 3]])> {
        self.is_found.then_some((self.seen.as_slice(), self.dragged_mm.as_slice()))
    }

    /// Takes the whole motion for a press until drag is looked for.
    pub(super) fn forget(&mut self) {
        self.is_found = false;
    }

    /// Looks how contact moves along the surface, and what that does to the gel; says whether it does anything.
    pub(super) fn find(&mut self, surface: &Surface, contact: &ContactFinder) -> bool {
        let Some((share, motion)) = motion_of(surface, contact).filter(|(share, _)| *share > 0.0) else {
            self.forget();
            return false;
        };
        let centres = self.coarse.grid.centres_mm().zip(self.coarse.around());
        for ((centre_mm, around), (touches, wanted)) in centres.zip(self.touches.iter_mut().zip(&mut self.wanted_mm)) {
            let [x, y] = motion.moves(centre_mm).map(|moved| (share * moved) as f32);
            (*touches, *wanted) = (contact.touches_around(around), [x, y, 0.0]);
        }
        self.tractions.hold(&self.touches, &self.wanted_mm, self.limits);
        self.coarse.to_surface(self.tractions.displacement_mm(), &mut self.dragged_mm);
        self.is_found = true;
        for ((cell, seen), &dragged_mm) in self.seen.iter_mut().enumerate().zip(&self.dragged_mm) {
            *seen = surface.without(cell, contact.depth_mm[cell], dragged_mm);
        }
        true
    }
}

impl Motion {
    /// The displacement of a point, mm.
    fn moves(self, at_mm: [f64; 2]) -> [f64; 2] {
        let [x, y] = [0, 1].map(|axis| at_mm[axis] - self.centre_mm[axis]);
        let (sin, cos) = self.turn.sin_cos();
        [self.shift_mm[0] + (cos - 1.0) * x - sin * y, self.shift_mm[1] + sin * x + (cos - 1.0) * y]
    }
}

/// How contact moves along the surface, by least squares, and which part of that is drag; none without contact.
fn motion_of(surface: &Surface, contact: &ContactFinder) -> Option<(f64, Motion)> {
    let cells = || (0..surface.grid.len()).filter(|&cell| contact.touches[cell]);
    let lateral_mm = |cell: usize| surface.seen[cell].lateral_mm(contact.depth_mm[cell]).map(f64::from);
    let mean = |of: &dyn Fn(usize) -> [f64; 2]| {
        let sum = cells().map(of).fold(([0.0; 2], 0.0), |([x, y], count), [dx, dy]| ([x + dx, y + dy], count + 1.0));
        sum.0.map(|total| total / sum.1)
    };
    let depths: f64 = cells().map(|cell| f64::from(contact.depth_mm[cell]).powi(2)).sum();
    if depths <= 0.0 {
        return None;
    }
    let (centre_mm, shift_mm) = (mean(&|cell| surface.centre_mm(cell)), mean(&lateral_mm));
    let (mut across, mut along) = (0.0, 0.0);
    for cell in cells() {
        let (at, moved) = (surface.centre_mm(cell), lateral_mm(cell));
        let from = [0, 1].map(|axis| at[axis] - centre_mm[axis]);
        let to = [0, 1].map(|axis| from[axis] + moved[axis] - shift_mm[axis]);
        across += from[0] * to[1] - from[1] * to[0];
        along += from[0] * to[0] + from[1] * to[1];
    }
    let motion = Motion { centre_mm, shift_mm, turn: across.atan2(along) };
    let square = |[x, y]: [f64; 2]| x * x + y * y;
    let moves: f64 = cells().map(|cell| square(motion.moves(surface.centre_mm(cell)))).sum();
    let all: f64 = cells().map(|cell| square(lateral_mm(cell))).sum();
    let beyond = |value: f64, [none, whole]: [f64; 2]| ((value - none) / (whole - none)).clamp(0.0, 1.0);
    Some((beyond((moves / depths).sqrt(), PARTIAL) * beyond(moves / all, PARTLY_STUCK), motion))
}

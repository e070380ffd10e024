//! The contact state of each surface node: free, held, or sliding.

use super::frame::{Frame, dot};
use crate::{ContactLaw, Relief};

/// A node this little inside the indenter does not touch it, mm.
const PENETRATION_MM: f64 = 1e-7;
/// A sliding node that repeatedly misses the face by more than this, mm, is wedged in an inner edge between two faces:
/// it is fixed at its place.
const WEDGED_MM: f64 = 1e-5;
/// A node is released only if it must be pulled by this share of the largest nodal force.
const PULL: f64 = 1e-7;
/// Largest number of changes of a node's state in a step; afterwards it stays in contact.
const MOST_CHANGES: u8 = 4;

/// The contact state of a surface node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Touch {
    /// No contact.
    Free,
    /// Stays at a point of the indenter, given in its frame, mm.
    Held { anchor: [f64; 3] },
    /// Slides on the face without friction.
    Sliding,
    /// Slides on the face with friction.
    Frictional(FrictionState),
}

/// Coulomb friction at a node.
///
/// The shear force grows with the slip up to its bound, the coefficient times the normal force, and is then constant:
/// `t = −bound · s / max(|s|, s₀)`. Sticking in Coulomb's law corresponds to a slip below `s₀`,
/// [`FrictionState::ELASTIC_SLIP_MM`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FrictionState {
    /// Point of the face that slip is counted from, in the indenter's frame, mm.
    pub(super) anchor: [f64; 3],
    /// Slip along the face, mm.
    slip: [f64; 3],
    /// Largest shear force, N.
    bound: f64,
}

impl FrictionState {
    /// Slip at which the shear force reaches its bound, mm.
    pub(super) const ELASTIC_SLIP_MM: f64 = 2e-3;

    /// The friction state when its node is at `place`, where the face has this normal.
    pub(super) fn moved_to(self, frame: &Frame, place: &[f64; 3], normal: &[f64; 3]) -> Self {
        let start = frame.gel_from_indenter(self.anchor);
        let way = [0, 1, 2].map(|c| place[c] - start[c]);
        let off = dot(&way, normal);
        Self { slip: [0, 1, 2].map(|c| way[c] - off * normal[c]), ..self }
    }

    /// Shear force on the gel, N.
    pub(super) fn drag(&self) -> [f64; 3] {
        let scale = -self.bound / length(&self.slip).max(Self::ELASTIC_SLIP_MM);
        self.slip.map(|slip| scale * slip)
    }

    /// Derivative of the friction force by further slip along the face, N/mm; `free` projects onto the face.
    pub(super) fn stiffness(&self, free: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
        let size = length(&self.slip);
        let scale = self.bound / size.max(Self::ELASTIC_SLIP_MM);
        let straight = if size > Self::ELASTIC_SLIP_MM { 1.0 / (size * size) } else { 0.0 };
        let entry = |r: usize, c: usize| scale * (free[r][c] - straight * self.slip[r] * self.slip[c]);
        [0, 1, 2].map(|r| [0, 1, 2].map(|c| entry(r, c)))
    }

    /// The friction state at the start of the next step: its anchor has followed the slip beyond the elastic slip.
    pub(super) fn at_rest(self, frame: &Frame, place: [f64; 3], relief: &dyn Relief) -> Self {
        let size = length(&self.slip);
        if size <= Self::ELASTIC_SLIP_MM {
            return self;
        }
        let share = Self::ELASTIC_SLIP_MM / size;
        let anchor = below(frame, relief, [0, 1, 2].map(|c| place[c] - share * self.slip[c]));
        Self { anchor, slip: self.slip.map(|slip| share * slip), ..self }
    }
}

/// Data of a node for the update of its state.
pub(super) struct Node<'a> {
    pub(super) relief: &'a dyn Relief,
    pub(super) law: ContactLaw,
    /// Indenter's frame at the last equilibrium and now.
    pub(super) frames: [&'a Frame; 2],
    /// The node's position at the last equilibrium and now, mm.
    pub(super) places: [[f64; 3]; 2],
    /// Its current contact force, N.
    pub(super) force: [f64; 3],
    /// Whether there were many iterations.
    pub(super) is_late: bool,
    /// Whether forces nearly balance, so that the normal force is meaningful.
    pub(super) is_balanced: bool,
    /// Norm of all nodal forces in contact, N.
    pub(super) contact_force: f64,
}

impl Node<'_> {
    /// The node's next state.
    pub(super) fn next(&self, touch: Touch, changes: u8) -> Touch {
        let Some(gap) = self.frames[1].gap(self.relief, self.places[1]) else { return Touch::Free };
        if touch == Touch::Free {
            return if gap.distance < -PENETRATION_MM { self.touched() } else { Touch::Free };
        }
        let push = dot(&self.force, &gap.normal);
        if push < -PULL * self.contact_force && changes < MOST_CHANGES {
            return Touch::Free;
        }
        if self.is_late && gap.distance.abs() > WEDGED_MM {
            return Touch::Held { anchor: self.below() };
        }
        match (touch, self.law) {
            (Touch::Frictional(friction), ContactLaw::Friction(coefficient)) => {
                let friction = friction.moved_to(self.frames[1], &self.places[1], &gap.normal);
                let bound = if self.is_balanced { coefficient * push.max(0.0) } else { friction.bound };
                Touch::Frictional(FrictionState { bound, ..friction })
            }
            _ => touch,
        }
    }

    /// The point of the face where the node is, in the indenter's frame.
    fn below(&self) -> [f64; 3] {
        below(self.frames[1], self.relief, self.places[1])
    }

    /// A node that has just come into contact.
    fn touched(&self) -> Touch {
        match self.law {
            ContactLaw::Frictionless | ContactLaw::LateStick => Touch::Sliding,
            ContactLaw::Stick => Touch::Held { anchor: self.anchor() },
            ContactLaw::Friction(_) => {
                Touch::Frictional(FrictionState { anchor: self.anchor(), slip: [0.0; 3], bound: 0.0 })
            }
        }
    }

    /// Point of the indenter that the node met on a straight path since the last equilibrium, in the indenter's frame.
    fn anchor(&self) -> [f64; 3] {
        let [from, to] = [0, 1].map(|n| self.frames[n].indenter_from_gel(self.places[n]));
        let at = |share: f64| [0, 1, 2].map(|c| from[c] + share * (to[c] - from[c]));
        let height = |point: &[f64; 3]| self.relief.at(point[0], point[1]).height_mm;
        let is_outside = |point: &[f64; 3]| point[2] + height(point) > 0.0;
        let (mut outside, mut inside) = (0.0, 1.0);
        if is_outside(&from) {
            for _ in 0..50 {
                let middle = 0.5 * (outside + inside);
                if is_outside(&at(middle)) { outside = middle } else { inside = middle }
            }
        } else {
            inside = 0.0;
        }
        let [x, y, _] = at(inside);
        [x, y, -height(&[x, y, 0.0])]
    }
}

/// The point of the indenter's face above or below a place, in the indenter's frame.
pub(super) fn below(frame: &Frame, relief: &dyn Relief, place: [f64; 3]) -> [f64; 3] {
    let [x, y, _] = frame.indenter_from_gel(place);
    [x, y, -relief.at(x, y).height_mm]
}

fn length(vector: &[f64; 3]) -> f64 {
    dot(vector, vector).sqrt()
}

//! Was the gel pressed when tracking began?
//!
//! A press moves the surface's points away from where it touches; a release from a pressed reference moves them towards
//! it. The *divergence* of a flow, `Σ f·(x − c) / Σ |f| |x − c|` about the centroid `c` of its magnitude, is near 1 for
//! the one, near −1 for the other and near 0 for shear. It is watched until the gel has first been touched or released.
//!
//! Compressible gel under a ball moves inwards, too. Where elasticity is known it tells the two apart: a release is no press
//! on any gel, so a press that fits in some frames in a row says that the gel was at rest at first.

use fingervision_flow::{Estimate, FlowField};

/// Flow that counts as motion, px: well above noise and slow drift.
const MOTION_PX: f32 = 0.5;
/// Divergence beyond which the direction is certain, dimensionless.
const CERTAIN: f32 = 0.5;
/// Change between frames below which the gel is still, px.
const STILL_PX: f32 = 0.05;
/// Frames in a row that elasticity explains as a press before the gel of the first image is taken for one at rest.
const EXPLAINED_FRAMES: u64 = 5;
/// Every so many pixels either way are looked at.
const STEP: usize = 8;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// Nothing has moved yet.
    Untouched,
    /// The gel moves inwards: the reference showed it pressed.
    Pressed {
        /// Frames in a row without motion.
        still: u64,
    },
    /// The reference shows the gel at rest.
    Settled,
}

/// Watches the first motion.
#[derive(Debug)]
pub(crate) struct StartUp {
    state: State,
    rest_frames: u64,
    /// Frames in a row, up to the last one, that are what a press on the gel of the first image makes.
    explained: u64,
}

impl StartUp {
    pub(crate) fn new(rest_frames: u64) -> Self {
        Self { state: State::Untouched, rest_frames, explained: 0 }
    }

    /// Whether the reference showed a pressed gel, as far as is known.
    pub(crate) fn is_pressed(&self) -> bool {
        self.explained == 0 && matches!(self.state, State::Pressed { .. })
    }

    /// Whether a gel that was pressed at the start has been still for long enough, and not because something holds it pressed.
    pub(crate) fn has_come_to_rest(&self) -> bool {
        self.explained == 0 && matches!(self.state, State::Pressed { still } if still >= self.rest_frames)
    }

    /// Takes note of whether elasticity explains the last frame as a press.
    pub(crate) fn note_press(&mut self, is_press: bool) {
        self.explained = if is_press { self.explained + 1 } else { 0 };
        if self.explained >= EXPLAINED_FRAMES {
            self.state = State::Settled;
        }
    }

    /// The reference has been replaced by one at rest.
    pub(crate) fn settle(&mut self) {
        self.state = State::Settled;
    }

    /// Looks at a frame that was found, given the flow of the one before.
    pub(crate) fn watch(&mut self, before: &FlowField, now: &Estimate) {
        match &mut self.state {
            State::Settled => {}
            State::Untouched => {
                if let Some(divergence) = divergence(now) {
                    if divergence < -CERTAIN {
                        self.state = State::Pressed { still: 0 };
                    } else if divergence > CERTAIN {
                        self.state = State::Settled;
                    }
                }
            }
            State::Pressed { still } => {
                *still = if largest_change(before, &now.flow) < STILL_PX { *still + 1 } else { 0 };
            }
        }
    }
}

fn samples(estimate: &Estimate) -> impl Iterator<Item = [f32; 4]> {
    let (width, height) = estimate.flow.size();
    let pixels = (0..height).step_by(STEP).flat_map(move |y| (0..width).step_by(STEP).map(move |x| (x, y)));
    pixels
        .filter(|&(x, y)| estimate.valid.at(x, y) == 1)
        .map(|(x, y)| [x as f32, y as f32, estimate.flow.u.at(x, y), estimate.flow.v.at(x, y)])
}

/// Divergence of a flow in which something moves; none otherwise.
fn divergence(estimate: &Estimate) -> Option<f32> {
    let moving = || samples(estimate).filter(|[_, _, u, v]| u.hypot(*v) > MOTION_PX);
    let (mut weight, mut x, mut y) = (0.0, 0.0, 0.0);
    for [px, py, u, v] in moving() {
        let length = u.hypot(v);
        weight += length;
        x += length * px;
        y += length * py;
    }
    if weight <= 0.0 {
        return None;
    }
    let (x, y) = (x / weight, y / weight);
    let (mut along, mut all, mut count) = (0.0, 0.0, 0);
    for [px, py, u, v] in moving() {
        along += u * (px - x) + v * (py - y);
        all += u.hypot(v) * (px - x).hypot(py - y);
        count += 1;
    }
    // A handful of pixels may be anything.
    (count >= 16 && all > 0.0).then(|| along / all)
}

fn largest_change(before: &FlowField, now: &FlowField) -> f32 {
    let (width, height) = now.size();
    let mut largest = 0.0_f32;
    for y in (0..height).step_by(STEP) {
        for x in (0..width).step_by(STEP) {
            let change = (now.u.at(x, y) - before.u.at(x, y)).hypot(now.v.at(x, y) - before.v.at(x, y));
            largest = largest.max(change);
        }
    }
    largest
}

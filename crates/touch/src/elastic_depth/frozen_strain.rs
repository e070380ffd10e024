//! The strain that a face keeps from the moment when the gel began to stick to it.
//!
//! Gel that slides under a face until friction holds it is strained when it begins to stick, and keeps that strain as long as it
//! sticks [Spence1968]. The face then still moves as a rigid body, but its points are closer together, or farther apart, than on
//! the gel at rest. Seen from a distance `H`, an even strain `e` looks like a depth of `e H`: 0.2 % at 25 mm looks like 0.05 mm.
//! The depth of a face is therefore that of its rigid motion plus a shift that does not change during a press.
//!
//! The shift is found at the start of the press. There the network's depth has a small error, because the depth itself is small; it
//! comes from the gel around the face and hardly depends on the strain. Later the rigid motion gives every change of depth far
//! more accurately. The differences between the two are averaged with the weight `g / (σ² + (ρ d)²)` at a depth `d`, where `g` is
//! the logarithm of the factor by which `d` exceeds the largest depth before, at most 1. A press in more images thus gives the same as
//! long as depth grows by less than a factor of e from one to the next, and a press that is held adds nothing.
//!
//! Most faces that stick do so from the first touch, without strain. Before the average is known, the shift is zero with a
//! probability of one half, and otherwise normally distributed [Mitchell1988]; its expectation once the average is known is
//! used. An average within its error thus hardly changes the depth, and one far beyond its error changes it fully.

#[cfg(test)]
mod tests;

/// Standard deviation of the strain of a face that is strained. In three presses of another finite-element program, in which gel
/// slides freely during the first 0.1 mm, the strain is −0.0028, −0.0023 and 0.0016.
const STRAIN: f64 = 0.002;
/// Standard deviation of the network's mean depth of a face: a constant, in thicknesses of the gel, and a part of the depth. With
/// these, depth was most accurate on presses of the simulator and of the other program together.
const NETWORK_ERROR: f64 = 0.0015;
const NETWORK_ERROR_BY_DEPTH: f64 = 0.1;
/// Frames without a face after which its strain is forgotten: it may have slid.
const MOST_MISSED_FRAMES: u32 = 3;

/// By how much a face is deeper than its rigid motion, and the standard deviation of that, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shift {
    pub(super) mm: f64,
    pub(super) deviation_mm: f64,
}

/// Finds the strain of a face from the frames of a press.
#[derive(Debug, Clone)]
pub(super) struct FrozenStrain {
    /// Standard deviation of the shift where the face is strained, mm.
    strained_mm: f64,
    /// Error of the network's depth where there is none, mm.
    constant_mm: f64,
    /// From the frames before, and with this one.
    before: Evidence,
    now: Evidence,
    was_compared: bool,
    missed: u32,
}

/// The weighted sum of differences, mm, between the network's depth and that of the rigid motion.
#[derive(Debug, Clone, Copy, Default)]
struct Evidence {
    weight: f64,
    sum: f64,
    /// The largest depth so far, mm.
    deepest_mm: f64,
}

impl FrozenStrain {
    /// None known, on a gel of this thickness, mm, seen from this distance, mm.
    pub(super) fn new(thickness_mm: f64, distance_mm: f64) -> Self {
        Self {
            strained_mm: STRAIN * distance_mm,
            constant_mm: NETWORK_ERROR * thickness_mm,
            before: Evidence::default(),
            now: Evidence::default(),
            was_compared: false,
            missed: 0,
        }
    }

    /// Forgets the press.
    pub(super) fn rest(&mut self) {
        (self.before, self.now) = (Evidence::default(), Evidence::default());
        (self.was_compared, self.missed) = (false, 0);
    }

    /// Begins a frame.
    pub(super) fn begin(&mut self) {
        self.missed = if self.was_compared { 0 } else { self.missed.saturating_add(1) };
        if self.missed >= MOST_MISSED_FRAMES {
            self.now = Evidence::default();
        }
        (self.before, self.was_compared) = (self.now, false);
    }

    /// Compares the mean depth of a face by its rigid motion, mm, with that by the network. A second comparison in the same frame
    /// replaces the first.
    pub(super) fn compare(&mut self, face_mm: f64, network_mm: f64) {
        (self.now, self.was_compared) = (self.before, true);
        let evidence = &mut self.now;
        // A depth that is not a number says nothing either.
        if network_mm.is_nan() || network_mm <= evidence.deepest_mm {
            return;
        }
        let gained = if evidence.deepest_mm > 0.0 { (network_mm / evidence.deepest_mm).ln().min(1.0) } else { 1.0 };
        let weight = gained / (self.constant_mm.powi(2) + (NETWORK_ERROR_BY_DEPTH * network_mm).powi(2));
        evidence.weight += weight;
        evidence.sum += weight * (network_mm - face_mm);
        evidence.deepest_mm = network_mm;
    }

    /// Forgets the comparisons of this frame, whose flow or depth is not to be trusted; it counts as a frame without a face.
    pub(super) fn discard(&mut self) {
        (self.now, self.was_compared) = (self.before, false);
    }

    /// What to add to the depth of the face's rigid motion.
    pub(super) fn shift(&self) -> Shift {
        let Evidence { weight, sum, .. } = self.now;
        let strained = self.strained_mm.powi(2);
        if weight <= 0.0 {
            return Shift { mm: 0.0, deviation_mm: (0.5 * strained).sqrt() };
        }
        let (mean_mm, variance) = (sum / weight, 1.0 / weight);
        let spread = strained + variance;
        // How much likelier the average is without strain than with it.
        let odds = (spread / variance).sqrt() * (0.5 * mean_mm.powi(2) * (1.0 / spread - 1.0 / variance)).exp();
        let is_strained = 1.0 / (1.0 + odds);
        let (if_strained_mm, left) = (mean_mm * strained / spread, strained * variance / spread);
        let variance = is_strained * (left + (1.0 - is_strained) * if_strained_mm.powi(2));
        Shift { mm: is_strained * if_strained_mm, deviation_mm: variance.sqrt() }
    }
}

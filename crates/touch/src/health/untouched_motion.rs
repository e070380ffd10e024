//! The motion of the whole image on the untouched gel, as of a camera that gets warm.
//!
//! The gel itself does not move, so elastic depth is computed without this motion. A light touch that is not detected also moves the image a
//! little. A flow therefore counts only if a shift, a rotation and a magnification explain it, if it came slowly, and if nothing touches the
//! gel in the interval after it.

use super::thresholds::THRESHOLDS;
use crate::whole_motion::{FittedMotion, WholeMotion};

/// What is known of the motion since the reference.
#[derive(Debug)]
pub(super) struct UntouchedMotion {
    accepted: WholeMotion,
    /// The motion at the end of the last interval; accepted at the end of the next one.
    candidate: Option<WholeMotion>,
    /// Whether the image has jumped since the reference. An object that drags the whole gel looks the same, so a jump is not undone.
    has_jumped: bool,
}

impl UntouchedMotion {
    /// No motion.
    pub(super) const NONE: Self = Self { accepted: WholeMotion::NONE, candidate: None, has_jumped: false };

    /// Takes the flow of the untouched gel at the end of an interval.
    pub(super) fn take(&mut self, fit: Option<FittedMotion>) {
        if let Some(motion) = self.candidate.take() {
            self.accepted = motion;
        }
        let is_even = |fit: &FittedMotion| fit.left_px <= THRESHOLDS.even_px.max(THRESHOLDS.most_bent * fit.flow_px);
        self.candidate = fit.filter(is_even).map(|fit| fit.motion);
    }

    /// Takes note of a jump of the whole image, away from the reference or back to it.
    pub(super) fn jump(&mut self, is_away: bool) {
        *self = Self { has_jumped: is_away, ..Self::NONE };
    }

    /// Something touches the gel.
    pub(super) fn disturb(&mut self) {
        self.candidate = None;
    }

    /// The motion, as far as it is sure.
    pub(super) fn known(&self) -> WholeMotion {
        if self.has_jumped { WholeMotion::NONE } else { self.accepted }
    }
}

//! Follows what moves while the shutter is open.
//!
//! Such a picture shows the gel blurred along its motion. A patch then matches with low contrast and a large residual,
//! and its displacement is wrong by a part of the blur, or it fails. Where that happens, the reference is blurred in
//! the same way, and the patches are matched with it. The motion is known from the flow of the last frame. How long the
//! shutter was open is not known: several exposures are tried, and the one that leaves the smallest residual is used.

mod exposures;
mod motion_blur;

pub(super) use self::motion_blur::MotionBlur;

use self::exposures::Exposures;
use super::{AffinePatches, AffineReference, LevelState};
use crate::{FlowField, FlowHistory, Picture};

/// Where the sharp reference gives no valid flow, the blurred one is used if it leaves at most this part of what the sharp one
/// leaves unexplained.
const IMPROVEMENT: f32 = 0.7;

impl AffinePatches {
    /// If the picture is blurred by the motion since the last frame, matches it with a blurred reference. Returns whether
    /// it does. `last` and `now` are memory for the last flow and the current one.
    ///
    /// After a search for the exposure that finds nothing, the next frame is not searched, which halves the cost of areas
    /// that stay hidden.
    pub(crate) fn follow_blur(
        &mut self,
        reference: &AffineReference,
        current: &Picture,
        history: &FlowHistory,
        [last, now]: [&mut FlowField; 2],
    ) -> bool {
        if std::mem::take(&mut self.blur.skips_next) || !self.is_blurred(reference, history) {
            return false;
        }
        // Patches that only need another step are not blurred.
        self.match_sharp(reference, current);
        if self.is_blurred(reference, history) {
            self.expand_last(history, last);
            self.blur.is_used = self.try_exposures(reference, current, history, (last, now));
            self.blur.skips_next = !self.blur.is_used;
        }
        self.blur.is_used
    }

    /// Whether the picture is blurred by the motion since the last frame.
    fn is_blurred(&mut self, reference: &AffineReference, history: &FlowHistory) -> bool {
        let LevelState { refinement, field, .. } = &self.levels[0];
        self.blur.set_motion(field, history.last_nodes());
        self.blur.find_blurred(refinement, &reference.full, self.params.validity.max_deviation_px.powi(2))
    }

    /// Takes another step with the sharp reference.
    fn match_sharp(&mut self, reference: &AffineReference, current: &Picture) {
        self.levels[0].refinement.trust_all();
        self.take_full_steps(reference, current, 1);
    }

    /// Matches the picture with the reference blurred by several exposures, and keeps the best. Returns whether the expected
    /// error is smaller than with the sharp reference, which is used otherwise.
    fn try_exposures(
        &mut self,
        reference: &AffineReference,
        current: &Picture,
        history: &FlowHistory,
        (last, now): (&FlowField, &mut FlowField),
    ) -> bool {
        let LevelState { refinement, field, .. } = &self.levels[0];
        let sharp = self.blur.mean_error(refinement, &reference.full, false);
        let sharp_unexplained = self.blur.mean_unexplained(refinement, &reference.full);
        self.blur.sharp.copy_from(field);
        self.blur.best.copy_from(field);
        self.expand(now);
        let mut exposures = Exposures::after(self.blur.exposure);
        while let Some(exposure) = exposures.next() {
            let found = self.match_blurred(reference, current, (last, now), exposure);
            if exposures.add(exposure, found) {
                self.blur.best.copy_from(&self.levels[0].field);
                self.expand(now);
            }
        }
        let best = exposures.best();
        if !exposures.is_best_last() {
            self.match_blurred(reference, current, (last, now), best.exposure);
        }
        let LevelState { refinement, field, .. } = &mut self.levels[0];
        self.blur.set_motion(field, history.last_nodes());
        self.blur.set_path_error(refinement, best.exposure);
        let blur = &self.blur;
        let blurred = blur.mean_error(refinement, &blur.reference.template, true);
        let is_sharp_valid = sharp <= self.params.validity.max_deviation_px.powi(2);
        if blurred < sharp || !is_sharp_valid && best.unexplained < IMPROVEMENT * sharp_unexplained {
            self.blur.exposure = Some(exposures.memory());
            return true;
        }
        field.copy_from(&self.blur.sharp);
        self.match_sharp(reference, current);
        false
    }

    /// Matches the picture with the reference blurred by one exposure, from the best field so far. Returns how much of the
    /// texture's variance it leaves unexplained in the blurred patches.
    fn match_blurred(
        &mut self,
        reference: &AffineReference,
        current: &Picture,
        motion: (&FlowField, &FlowField),
        exposure: f32,
    ) -> f32 {
        let Self { levels, blur, params, .. } = self;
        let level = &mut levels[0];
        level.refinement.blur(&reference.full, motion, exposure, &mut blur.reference);
        level.refinement.trust_all();
        level.field.copy_from(&blur.best);
        level.take_full_steps(params, &blur.reference.template, (current, reference.gain(current)), 1);
        blur.mean_unexplained(&level.refinement, &blur.reference.template)
    }
}

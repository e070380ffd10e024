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

/// The blurred reference is used if it leaves at most this part of what the sharp one leaves unexplained. In sharp pictures it leaves
/// 0.68 to 0.98 of that of a steep wall beside a contact, which is foreshortened and partly hidden; in blurred ones mostly 0.1 to 0.6.
/// Measured on simulated presses.
const IMPROVEMENT: f32 = 0.65;

/// How the patches that look blurred match with one reference.
#[derive(Debug, Clone, Copy)]
struct Match {
    /// Mean square of their error, px².
    error_px2: f32,
    /// Part of the texture's variance that is left unexplained, 0 to 1.
    unexplained: f32,
}

impl Match {
    /// Whether a blurred reference explains clearly more than the sharp one. If the sharp one gives a valid flow, with a mean
    /// square of the error of up to `most_px2`, that of the blurred one must be more accurate, too.
    fn explains_more_than(self, sharp: Self, most_px2: f32) -> bool {
        let is_sharp_valid = sharp.error_px2 <= most_px2;
        (self.error_px2 < sharp.error_px2 || !is_sharp_valid) && self.unexplained < IMPROVEMENT * sharp.unexplained
    }
}

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
        // Also where no search follows: how likely blur is comes from it.
        let is_blurred = self.is_blurred(reference, history);
        if std::mem::take(&mut self.blur.skips_next) || !is_blurred {
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

    /// Matches the picture with the reference blurred by several exposures, and keeps the best. Returns whether it explains clearly
    /// more than the sharp reference, which is used otherwise.
    fn try_exposures(
        &mut self,
        reference: &AffineReference,
        current: &Picture,
        history: &FlowHistory,
        (last, now): (&FlowField, &mut FlowField),
    ) -> bool {
        let LevelState { refinement, field, .. } = &self.levels[0];
        let sharp = Match {
            error_px2: self.blur.mean_error(refinement, &reference.full, false),
            unexplained: self.blur.mean_unexplained(refinement, &reference.full),
        };
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
        let blurred = Match {
            error_px2: blur.mean_error(refinement, &blur.reference.template, true),
            unexplained: best.unexplained,
        };
        if blurred.explains_more_than(sharp, self.params.validity.max_deviation_px.powi(2)) {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reference_that_explains_hardly_more_is_not_taken() {
        let is_taken = |(sharp_px, sharp): (f32, f32), (blurred_px, blurred): (f32, f32)| {
            let [sharp, blurred] = [(sharp_px, sharp), (blurred_px, blurred)]
                .map(|(px, unexplained)| Match { error_px2: px * px, unexplained });
            blurred.explains_more_than(sharp, 0.25)
        };
        // Sharp pictures of the wall beside a deep contact, as measured.
        assert!(!is_taken((0.79, 0.48), (0.72, 0.40)) && !is_taken((0.76, 0.50), (0.89, 0.34)));
        // Pictures that are blurred by motion.
        assert!(is_taken((0.76, 0.37), (0.35, 0.03)) && is_taken((0.733, 0.39), (0.735, 0.11)));
        // The sharp reference gives a valid flow.
        assert!(is_taken((0.3, 0.3), (0.2, 0.1)) && !is_taken((0.3, 0.3), (0.4, 0.1)));
    }
}

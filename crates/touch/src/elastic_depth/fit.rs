//! Whether the motion is that of the gel and camera of the profile, from frame to frame.
//!
//! A frame is a misfit if the motion that the tractions do not explain is too large, relative to contact. A camera that was bumped
//! adds an even motion, which becomes smaller relative to contact as the press deepens, and depth and force are nevertheless wrong.
//! After a misfit the gel therefore has to fit well, or to come to rest. A single bad image, torn or hidden in part, must not end
//! the measurement of a press that fits only moderately: it fits again if hardly more is unexplained than before the misfit, and
//! little of that is an even motion.

use super::thresholds::THRESHOLDS;

/// After a misfit the unexplained part has to be below this part of the usual limit ...
const WELL: f64 = 0.5;
/// ... or below the part before the misfit times this and in proportion to how far contact moved, because large strain is what is not
/// explained. In presses of a letter the part grows with the power 0.6 of the depth.
const AS_BEFORE: f64 = 1.1;
/// Then it must also be below this part of the usual limit, so that a press at the limit does not come and go, ...
const CLEARLY: f64 = 0.9;
/// ... contact must not be farther from its place at rest than before by more than this factor, ...
const LARGER: f64 = 2.5;
/// ... and the even motion must be below this part of the limit. A bump along the camera's axis is not an even motion in this sense.
const EVEN: f64 = 0.3;

/// Judges the frames of a press.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Fit {
    is_misfit: bool,
    /// Of the last frame that fitted, as long as the gel has not been at rest.
    before: Option<Unexplained>,
}

/// Motion that is not explained.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Unexplained {
    /// Its root mean square, relative to [`Self::farthest_mm`].
    pub(super) part: f64,
    /// The same of the translation and rotation in it.
    pub(super) even: f64,
    /// How far contact moved, mm.
    pub(super) farthest_mm: f64,
}

impl Fit {
    /// Forgets the press.
    pub(super) fn rest(&mut self) {
        *self = Self::default();
    }

    /// Whether a frame is a misfit. A frame with too little motion to decide has the result of the frame before. Later frames are compared
    /// with this one only if its image is to be trusted.
    pub(super) fn is_misfit(&mut self, now: Option<Unexplained>, is_trusted: bool) -> bool {
        let Some(now) = now else { return self.is_misfit };
        let fits = if self.is_misfit { self.fits_again(now) } else { now.part <= THRESHOLDS.most_unexplained };
        self.is_misfit = !fits;
        if fits && is_trusted {
            self.before = Some(now);
        }
        self.is_misfit
    }

    fn fits_again(&self, now: Unexplained) -> bool {
        let most = THRESHOLDS.most_unexplained;
        let fits_as_before = self.before.is_some_and(|before| {
            let larger = now.farthest_mm / before.farthest_mm;
            larger <= LARGER
                && now.part <= (CLEARLY * most).min(AS_BEFORE * before.part * larger.max(1.0))
                && now.even <= EVEN * most
        });
        now.part <= WELL * most || fits_as_before
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MOST: f64 = THRESHOLDS.most_unexplained;

    /// A press of this depth, mm, of which the tractions do not explain this part, and an even motion, mm, beside it.
    fn seen(part: f64, depth_mm: f64, bump_mm: f64) -> Unexplained {
        let even = bump_mm / depth_mm;
        Unexplained { part: part.hypot(even), even, farthest_mm: depth_mm }
    }

    #[test]
    fn a_bad_image_does_not_end_a_press_that_fits_moderately() {
        let mut fit = Fit::default();
        for depth_mm in [0.8, 0.9, 1.0] {
            assert!(!fit.is_misfit(Some(seen(0.6 * MOST * depth_mm, depth_mm, 0.0)), true));
        }
        assert!(fit.is_misfit(Some(seen(3.0 * MOST, 1.2, 0.0)), true), "the bad image");
        assert!(!fit.is_misfit(Some(seen(0.84 * MOST, 1.4, 0.0)), true), "the next one");
    }

    #[test]
    fn a_bumped_camera_stays_a_misfit_until_the_bump_is_small_relative_to_the_press() {
        for part in [0.2, 0.4, 0.6, 0.8, 0.9] {
            let mut fit = Fit::default();
            assert!(!fit.is_misfit(Some(seen(part * MOST, 1.0, 0.0)), true));
            let bump_mm = 1.01 * (MOST * MOST - (part * MOST).powi(2)).sqrt();
            for step in 0..=20 {
                let depth_mm = 1.0 + 0.1 * f64::from(step);
                let is_misfit = fit.is_misfit(Some(seen(part * MOST, depth_mm, bump_mm)), true);
                let is_small = part.hypot(bump_mm / depth_mm / MOST) <= WELL || bump_mm / depth_mm <= EVEN * MOST;
                assert!(is_misfit || is_small, "{part} at {depth_mm} mm");
                assert!(is_misfit || depth_mm > 1.35, "{part} at {depth_mm} mm");
            }
        }
    }

    #[test]
    fn a_press_at_the_limit_does_not_come_and_go() {
        let mut fit = Fit::default();
        let mut judge = |part| fit.is_misfit(Some(seen(part * MOST, 1.0, 0.0)), true);
        assert_eq!([0.98, 1.02, 0.98, 0.95, 1.02, 0.98].map(&mut judge), [false, true, true, true, true, true]);
    }

    #[test]
    fn an_image_that_is_not_trusted_is_no_measure_for_the_next() {
        let mut fit = Fit::default();
        assert!(!fit.is_misfit(Some(seen(0.4 * MOST, 1.0, 0.0)), true));
        assert!(!fit.is_misfit(Some(seen(0.9 * MOST, 1.0, 0.0)), false));
        assert!(fit.is_misfit(Some(seen(1.1 * MOST, 1.0, 0.0)), true));
        assert!(fit.is_misfit(Some(seen(0.8 * MOST, 1.0, 0.0)), true));
    }

    #[test]
    fn a_misfit_from_the_first_touch_on_needs_a_good_fit_or_rest() {
        let mut fit = Fit::default();
        assert!(fit.is_misfit(Some(seen(1.1 * MOST, 1.0, 0.0)), true));
        assert!(fit.is_misfit(Some(seen(0.8 * MOST, 1.0, 0.0)), true));
        assert!(fit.is_misfit(None, true));
        assert!(!fit.is_misfit(Some(seen(0.4 * MOST, 1.0, 0.0)), true));
        assert!(fit.is_misfit(Some(seen(1.1 * MOST, 1.0, 0.0)), true));
        fit.rest();
        assert!(!fit.is_misfit(Some(seen(0.8 * MOST, 1.0, 0.0)), true));
    }
}

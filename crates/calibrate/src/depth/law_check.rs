//! Rejects fitted laws that no sensor can have.
//!
//! A line can also be fitted to depths in another unit. These limits are wide: they accept every camera-based sensor.

use fingervision_touch::{DepthLaw, Profile};

use super::thresholds::THRESHOLDS;
use super::{DepthFit, DepthFitError, FittedLaw};

impl DepthFit {
    /// Refuses a law of this fit that no sensor can have, or that does not reproduce the depths of the presses.
    ///
    /// # Errors
    ///
    /// [`DepthFitError::Impossible`] or [`DepthFitError::Useless`].
    pub fn check(&self, law: &FittedLaw, profile: &Profile) -> Result<(), DepthFitError> {
        // The slope of the line through the origin over that by perspective alone for the same presses.
        let gain = self.perspective.map(|perspective| perspective.slope);
        if let Some(gain) = gain.filter(|gain| !(THRESHOLDS.gains[0]..=THRESHOLDS.gains[1]).contains(gain)) {
            let expected_mm = profile.camera.map_or(f64::NAN, |camera| 0.5 * camera.translation_mm[2]);
            return Err(DepthFitError::Impossible { slope_mm: self.origin.slope, expected_mm, factor: gain });
        }
        if let DepthLaw::Line(line) = law.law
            && !(THRESHOLDS.slopes_mm[0]..=THRESHOLDS.slopes_mm[1]).contains(&line.slope_mm)
        {
            let expected_mm = line.slope_mm.clamp(THRESHOLDS.slopes_mm[0], THRESHOLDS.slopes_mm[1]);
            let factor = line.slope_mm / expected_mm;
            return Err(DepthFitError::Impossible { slope_mm: line.slope_mm, expected_mm, factor });
        }
        let depths = self.presses.iter().flat_map(|press| &press.curve.points).map(|point| point.depth_mm);
        let deepest_mm = depths.fold(0.0, f64::max);
        let error_mm = law.left_out_error_mm.unwrap_or(law.error_mm);
        if error_mm > THRESHOLDS.most_error * deepest_mm {
            return Err(DepthFitError::Useless { error_mm, deepest_mm });
        }
        Ok(())
    }
}

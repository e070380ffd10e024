//! Possible depths of a press, and possible laws fitted to presses.
//!
//! A table in another unit, with another sign or in another order still gives a line. These limits are wide: they accept
//! every camera-based sensor, and reject what no sensor can be.

use fingervision_touch::{DepthLaw, Profile};

use super::{DepthFit, DepthFitError, FittedLaw};

/// The first depth of a press may differ from zero by this part of its largest: the accuracy of a hand-set zero.
const REST: f64 = 0.02;
/// No gel is pressed deeper, mm.
const DEEPEST_MM: f64 = 50.0;
/// A shallower press moves the pattern by less than noise, mm.
const SHALLOWEST_MM: f64 = 0.02;
/// If the correlation of feature and depth of a press is less than this, the press does not show that depth,
/// dimensionless. Simulated presses have 0.8 and more, sliding faces included.
const LEAST_CORRELATION: f64 = 0.6;
/// Error on presses that were left out over the deepest depth. A law without any information has 0.6.
const MOST_ERROR: f64 = 0.5;
/// Gains over that of perspective alone: simulated sensors have 0.5 to 2.
const GAINS: [f64; 2] = [0.05, 20.0];
/// Slopes allowed without a camera, mm: half the distance to the camera by perspective alone.
const SLOPES_MM: [f64; 2] = [0.1, 1000.0];

/// Refuses depths that are not those of a press on this sensor.
pub(crate) fn check_depths(press: &str, depths_mm: &[f64], profile: &Profile) -> Result<(), DepthFitError> {
    let press = press.to_owned();
    let Some(&first) = depths_mm.first() else { return Err(DepthFitError::Count { press, images: 1, depths: 0 }) };
    let (least, most) = depths_mm.iter().fold((first, first), |(low, high), &depth| (depth.min(low), depth.max(high)));
    if least >= most {
        return Err(DepthFitError::Constant { press, depth_mm: first });
    }
    let rest_mm = REST * most.abs();
    if let Some(frame) = depths_mm.iter().position(|&depth| depth < -rest_mm) {
        return Err(DepthFitError::Negative { press, frame, depth_mm: depths_mm[frame] });
    }
    let (most_mm, limit) = deepest(profile);
    if most > most_mm {
        return Err(DepthFitError::TooDeep { press, depth_mm: most, most_mm, limit });
    }
    if most < SHALLOWEST_MM {
        return Err(DepthFitError::TooShallow { press, depth_mm: most, least_mm: SHALLOWEST_MM });
    }
    if first.abs() > rest_mm {
        return Err(DepthFitError::PressedAtStart { press, depth_mm: Some(first) });
    }
    Ok(())
}

/// The largest possible depth for a sensor, mm, and its reason.
fn deepest(profile: &Profile) -> (f64, &'static str) {
    let gel = profile.gel.map(|gel| (gel.thickness_mm, "the gel's thickness"));
    let camera = profile.camera.map(|camera| (camera.translation_mm[2], "the distance to the camera"));
    let limits = [Some((DEEPEST_MM, "more than any gel")), gel, camera].into_iter().flatten();
    limits.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((DEEPEST_MM, "more than any gel"))
}

impl DepthFit {
    /// Refuses a law of this fit that no sensor can have, or that does not reproduce the depths of the presses.
    ///
    /// # Errors
    ///
    /// [`DepthFitError::Unordered`], [`DepthFitError::Impossible`] or [`DepthFitError::Useless`].
    pub fn check(&self, law: &FittedLaw, profile: &Profile) -> Result<(), DepthFitError> {
        if let Some(press) = self.presses.iter().find(|press| press.line.correlation < LEAST_CORRELATION) {
            let correlation = press.line.correlation;
            return Err(DepthFitError::Unordered { press: press.curve.name.clone(), correlation });
        }
        // The slope of the line through the origin over that by perspective alone for the same presses.
        let gain = self.perspective.map(|perspective| perspective.slope);
        if let Some(gain) = gain.filter(|gain| !(GAINS[0]..=GAINS[1]).contains(gain)) {
            let expected_mm = profile.camera.map_or(f64::NAN, |camera| 0.5 * camera.translation_mm[2]);
            return Err(DepthFitError::Impossible { slope_mm: self.origin.slope, expected_mm, factor: gain });
        }
        if let DepthLaw::Line(line) = law.law
            && !(SLOPES_MM[0]..=SLOPES_MM[1]).contains(&line.slope_mm)
        {
            let expected_mm = line.slope_mm.clamp(SLOPES_MM[0], SLOPES_MM[1]);
            let factor = line.slope_mm / expected_mm;
            return Err(DepthFitError::Impossible { slope_mm: line.slope_mm, expected_mm, factor });
        }
        let depths = self.presses.iter().flat_map(|press| &press.curve.points).map(|point| point.depth_mm);
        let deepest_mm = depths.fold(0.0, f64::max);
        let error_mm = law.left_out_error_mm.unwrap_or(law.error_mm);
        if error_mm > MOST_ERROR * deepest_mm {
            return Err(DepthFitError::Useless { error_mm, deepest_mm });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depths_that_are_none_of_a_press_are_refused() {
        let refusal = |depths: &[f64]| check_depths("a", depths, &Profile::default()).unwrap_err().to_string();
        assert_eq!(refusal(&[0.5, 0.5, 0.5]), "a: its depth never changes: 0.5 mm in every frame");
        assert_eq!(refusal(&[0.5, 1.0]), "a: it is pressed already at the start: 0.5 mm in the first frame");
        assert_eq!(refusal(&[]), "a: 1 images, but 0 depths");
        assert_eq!(refusal(&[0.0, -0.5, -1.0]), "a: frame 1 has a negative depth, -0.5 mm");
        assert_eq!(refusal(&[0.0, 500.0, 1000.0]), "a: its deepest depth is 1000 mm, and 50 mm is more than any gel");
        assert_eq!(refusal(&[0.0, 0.001]), "a: its deepest depth is 0.001 mm: below 0.02 mm nothing is seen to move");
        check_depths("a", &[0.01, 0.5, 1.0, 0.0], &Profile::default()).unwrap();
        let gel = "name = 'a'\n[gel]\nsize_mm = [30.0, 30.0]\nthickness_mm = 3.0\npoissons_ratio = 0.48\n";
        let error = check_depths("a", &[0.0, 3.5], &Profile::from_toml(gel).unwrap()).unwrap_err();
        assert_eq!(error.to_string(), "a: its deepest depth is 3.5 mm, and 3 mm is the gel's thickness");
        assert!(error.hint().unwrap().contains("µm"), "{error:?}");
    }
}

//! Possible depths of a press, and possible laws fitted to presses.
//!
//! A line can also be fitted to a table in another unit, with another sign or in another order. These limits are wide:
//! they accept every camera-based sensor and reject values that no sensor can have.

use fingervision_touch::Profile;

use super::DepthFitError;
use super::thresholds::THRESHOLDS;

/// Refuses depths that are not those of a press on this sensor.
pub(crate) fn check_depths(press: &str, depths_mm: &[f64], profile: &Profile) -> Result<(), DepthFitError> {
    let press = press.to_owned();
    let Some(&first) = depths_mm.first() else { return Err(DepthFitError::Count { press, images: 1, depths: 0 }) };
    let (least, most) = depths_mm.iter().fold((first, first), |(low, high), &depth| (depth.min(low), depth.max(high)));
    if least >= most {
        return Err(DepthFitError::Constant { press, depth_mm: first });
    }
    let rest_mm = THRESHOLDS.most_depth_at_rest * most.abs();
    if let Some(frame) = depths_mm.iter().position(|&depth| depth < -rest_mm) {
        return Err(DepthFitError::Negative { press, frame, depth_mm: depths_mm[frame] });
    }
    let (most_mm, limit) = deepest(profile);
    if most > most_mm {
        return Err(DepthFitError::TooDeep { press, depth_mm: most, most_mm, limit });
    }
    if most < THRESHOLDS.shallowest_mm {
        return Err(DepthFitError::TooShallow { press, depth_mm: most, least_mm: THRESHOLDS.shallowest_mm });
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
    let limits = [Some((THRESHOLDS.deepest_mm, "the limit for any gel")), gel, camera].into_iter().flatten();
    limits.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((THRESHOLDS.deepest_mm, "the limit for any gel"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depths_that_are_none_of_a_press_are_refused() {
        let refusal = |depths: &[f64]| check_depths("a", depths, &Profile::default()).unwrap_err().to_string();
        assert_eq!(refusal(&[0.5, 0.5, 0.5]), "a: the depth is the same in every frame: 0.5 mm");
        assert_eq!(refusal(&[0.5, 1.0]), "a: the gel is already pressed at the start: 0.5 mm in the first frame");
        assert_eq!(refusal(&[]), "a: 1 images, but 0 depths");
        assert_eq!(refusal(&[0.0, -0.5, -1.0]), "a: frame 1 has a negative depth, -0.5 mm");
        assert_eq!(
            refusal(&[0.0, 500.0, 1000.0]),
            "a: its largest depth is 1000 mm, above 50 mm, the limit for any gel"
        );
        assert_eq!(refusal(&[0.0, 0.001]), "a: its largest depth is 0.001 mm: below 0.02 mm no motion can be measured");
        check_depths("a", &[0.01, 0.5, 1.0, 0.0], &Profile::default()).unwrap();
        let gel = "name = 'a'\n[gel]\nsize_mm = [30.0, 30.0]\nthickness_mm = 3.0\npoissons_ratio = 0.48\n";
        let error = check_depths("a", &[0.0, 3.5], &Profile::from_toml(gel).unwrap()).unwrap_err();
        assert_eq!(error.to_string(), "a: its largest depth is 3.5 mm, above 3 mm, the gel's thickness");
        assert!(error.hint().unwrap().contains("µm"), "{error:?}");
    }
}

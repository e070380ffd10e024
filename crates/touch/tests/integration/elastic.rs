//! The fields of a reading with elastic depth: which are computed, their sizes, and when they are absent.

use fingervision_gel::{Light, Motion, Sheet, SheetRenderer};
use fingervision_image::{Frame, Pixels};
use fingervision_touch::{Fields, Flag, Profile, TrackError, Tracker};

const SIZE: (usize, usize) = (160, 120);
const SENSOR: &str = "[camera]\nfocal_length_px = [160, 160]\nprincipal_point_px = [79.5, 59.5]\n\
                      translation_mm = [0, 0, 20]\n\
                      [gel]\nsize_mm = [30, 30]\nthickness_mm = 8\npoissons_ratio = 0.48\nyoungs_modulus_mpa = 0.6\n";
const ALL: Fields = Fields { density: true, depth: true, displacement: true, traction: true };

fn tracker(profile: &Profile, fields: Fields) -> Tracker {
    Tracker::new(profile, SIZE, true, fields).unwrap()
}

fn frame(sequence: u64, pattern_seed: u64, motion: &Motion) -> Frame {
    let sheet = Sheet { width: SIZE.0, height: SIZE.1, pattern_seed, ..Sheet::default() };
    let image = SheetRenderer::new(&sheet).unwrap().render(motion, Light::EVEN, 100 + sequence).unwrap();
    Frame { sequence, capture_time_s: sequence as f64 / 90.0, pixels: Pixels::Rgb8(image) }
}

#[test]
fn every_field_that_was_asked_for_lies_on_the_reference_grid() {
    let profile = Profile::from_toml(SENSOR).unwrap();
    let mut tracker = tracker(&profile, ALL);
    let promised = tracker.reading().clone();
    let reading = tracker.track(&frame(0, 1, &Motion::STILL)).unwrap();
    for plane in [&reading.density, &reading.depth, &reading.depth_deviation] {
        assert_eq!(plane.as_ref().unwrap().size(), SIZE);
    }
    assert_eq!(reading.contact.as_ref().unwrap().size(), SIZE);
    assert!(reading.displacement.as_ref().unwrap().iter().all(|plane| plane.size() == SIZE));
    let (found, expected) = (reading.traction.as_ref().unwrap(), promised.traction.unwrap());
    assert_eq!(
        (found.columns, found.rows, found.traction_mpa.len()),
        (expected.columns, expected.rows, expected.columns * expected.rows)
    );
    assert!(reading.depth.as_ref().unwrap().values().iter().all(|depth| depth.is_finite()));
    assert!(reading.max_depth_mm.unwrap().abs() < 0.1, "{:?} mm deep at rest", reading.max_depth_mm);
    assert!(reading.contact_area_mm2.is_some() && reading.force_n.is_some() && reading.torque_nmm.is_some());
}

#[test]
fn without_youngs_modulus_only_force_and_traction_are_absent() {
    let profile = Profile::from_toml(&SENSOR.replace("youngs_modulus_mpa = 0.6\n", "")).unwrap();
    let mut tracker = tracker(&profile, ALL);
    let reading = tracker.track(&frame(0, 1, &Motion::STILL)).unwrap();
    assert!(reading.depth.is_some() && reading.displacement.is_some() && reading.contact_area_mm2.is_some());
    assert!(reading.traction.is_none() && reading.force_n.is_none() && reading.torque_nmm.is_none());
}

#[test]
fn what_was_not_asked_for_is_absent() {
    let profile = Profile::from_toml(SENSOR).unwrap();
    let mut flow_alone = tracker(&profile, Fields::NONE);
    let reading = flow_alone.track(&frame(0, 1, &Motion::STILL)).unwrap();
    assert!(reading.depth.is_none() && reading.contact.is_none() && reading.force_n.is_none());
    let mut depth_alone = tracker(&profile, Fields { depth: true, ..Fields::NONE });
    let reading = depth_alone.track(&frame(0, 1, &Motion::STILL)).unwrap();
    assert!(reading.depth.is_some() && reading.contact.is_some() && reading.force_n.is_some());
    assert!(reading.density.is_none() && reading.displacement.is_none() && reading.traction.is_none());
}

#[test]
fn a_frame_that_is_lost_has_no_depth_and_no_force() {
    let profile = Profile::from_toml(SENSOR).unwrap();
    let mut tracker = tracker(&profile, ALL);
    tracker.track(&frame(0, 1, &Motion::STILL)).unwrap();
    let reading = tracker.track(&frame(1, 77, &Motion::STILL)).unwrap();
    assert!(reading.flags.has(Flag::Lost), "{}", reading.flags);
    assert!(reading.depth_deviation.as_ref().unwrap().values().iter().all(|deviation| deviation.is_infinite()));
    assert!(reading.depth.as_ref().unwrap().values().iter().all(|&depth| depth == 0.0));
    assert!(reading.contact.as_ref().unwrap().values().iter().all(|&contact| contact == 0));
    assert!(reading.traction.as_ref().unwrap().traction_mpa.iter().flatten().all(|&part| part == 0.0));
    assert!(reading.max_depth_mm.is_none() && reading.contact_area_mm2.is_none());
    assert!(reading.force_n.is_none() && reading.torque_nmm.is_none());
    let reading = tracker.track(&frame(2, 1, &Motion::STILL)).unwrap();
    assert!(reading.max_depth_mm.is_some() && reading.force_n.is_some(), "{}", reading.flags);
}

#[test]
fn density_has_no_contact_and_no_force() {
    let mut profile = Profile::from_toml(SENSOR).unwrap();
    profile.set_all([("depth.method", "density"), ("depth.density", "{ gain = 0.7 }")]).unwrap();
    let mut tracker = tracker(&profile, ALL);
    let reading = tracker.track(&frame(0, 1, &Motion::STILL)).unwrap();
    assert!(reading.depth.is_some() && reading.density.is_some());
    assert!(reading.contact.is_none() && reading.displacement.is_none() && reading.depth_deviation.is_none());
    assert!(reading.traction.is_none() && reading.force_n.is_none() && reading.contact_area_mm2.is_none());
}

#[test]
fn elastic_depth_without_gel_or_camera_is_refused_where_it_is_asked_for() {
    let mut profile = Profile::default();
    profile.set("depth.method", "elastic").unwrap();
    let error = Tracker::new(&profile, SIZE, true, Fields::default()).unwrap_err();
    assert_eq!(error.to_string(), "depth.method = \"elastic\" needs [camera], which is missing in the profile");
    assert!(matches!(error, TrackError::Profile(_)) && error.hint().is_some());
    assert!(Tracker::new(&profile, SIZE, true, Fields::NONE).is_ok());
}

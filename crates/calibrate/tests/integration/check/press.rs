use std::path::PathBuf;

use fingervision_calibrate::check::{PressCheck, RecordingCheck, What};
use fingervision_calibrate::depth::PressFolder;
use fingervision_gel::Motion;
use fingervision_image::Frame;
use fingervision_touch::Profile;

use super::rendered::{Camera, SIZE, expect_only, judged};

const FRAMES: usize = 6;

/// A press with this largest motion, px, around a point.
fn press(camera: Camera, centre_px: [f64; 2], amplitude_px: f64) -> Vec<Frame> {
    let deepest = Motion::RadialBump { centre_px, radius_px: 25.0, amplitude_px };
    camera.record((0..FRAMES).map(|number| deepest.at(number as f64 / (FRAMES - 1) as f64)))
}

fn folder(depths_mm: Vec<f64>) -> PressFolder {
    PressFolder { name: "press-1".into(), images: PathBuf::new(), depths_mm, forces_n: None }
}

fn check(frames: &[Frame]) -> RecordingCheck {
    let folder = folder((0..FRAMES).map(|number| 0.2 * number as f64).collect());
    judged(Box::new(PressCheck::new(&folder, &Profile::default(), SIZE, true).unwrap()), frames)
}

const MIDDLE: [f64; 2] = [63.5, 47.5];

#[test]
fn a_press_passes() {
    let found = check(&press(Camera::GOOD, MIDDLE, 4.0));
    assert!(found.is_sound(), "{found:?}");
    assert!((found.motion_px.unwrap() - 4.0).abs() < 0.2, "{found:?}");
}

#[test]
fn every_fault_of_a_press_is_named_alone() {
    expect_only(What::Unsharp, &check(&press(Camera::BLURRED, MIDDLE, 4.0)));
    expect_only(What::TooBright, &check(&press(Camera::OVEREXPOSED, MIDDLE, 4.0)));
    expect_only(What::TooDark, &check(&press(Camera::DARK, MIDDLE, 4.0)));
    expect_only(What::Unsharp, &check(&press(Camera::WITHOUT_PATTERN, MIDDLE, 4.0)));
    expect_only(What::MotionTooSmall, &check(&press(Camera::GOOD, MIDDLE, 0.3)));
    expect_only(What::CutByBorder, &check(&press(Camera::GOOD, [4.0, 47.5], 4.0)));
    expect_only(What::Count, &check(&press(Camera::GOOD, MIDDLE, 4.0)[..FRAMES - 1]));
    let mut released = press(Camera::GOOD, MIDDLE, 4.0);
    released.reverse();
    for (number, frame) in released.iter_mut().enumerate() {
        (frame.sequence, frame.capture_time_s) = (number as u64, number as f64 / 30.0);
    }
    expect_only(What::PressedAtStart, &check(&released));
    let elsewhere = |number| Motion::Shift { by_px: [if number > 0 { 400.0 } else { 0.0 }, 0.0] };
    expect_only(What::Lost, &check(&Camera::GOOD.record((0..FRAMES).map(elsewhere))));
}

#[test]
fn depths_that_are_none_of_a_press_are_refused_at_once() {
    let refused = |depths_mm| PressCheck::new(&folder(depths_mm), &Profile::default(), SIZE, true).unwrap_err().what;
    assert_eq!(refused(vec![0.5; 6]), What::Depths);
    assert_eq!(refused(vec![0.5, 0.6, 1.0]), What::PressedAtStart);
    assert_eq!(refused(Vec::new()), What::Count);
}

/// The result for a press, given this recording of the untouched gel.
fn check_beside(rest: &Frame, frames: &[Frame]) -> RecordingCheck {
    let folder = folder((0..FRAMES).map(|number| 0.2 * number as f64).collect());
    let check = PressCheck::new(&folder, &Profile::default(), SIZE, true).unwrap();
    judged(Box::new(check.with_rest(rest).unwrap()), frames)
}

#[test]
fn the_first_image_is_compared_with_the_untouched_gel() {
    let frames = press(Camera::GOOD, MIDDLE, 4.0);
    let rest = &Camera::GOOD.record(std::iter::once(Motion::STILL))[0];
    assert!(check_beside(rest, &frames).is_sound());
    let held = Motion::RadialBump { centre_px: MIDDLE, radius_px: 25.0, amplitude_px: 4.0 };
    let begun = Camera::GOOD.record((0..FRAMES).map(|number| held.at(0.4 + 0.1 * number as f64)));
    expect_only(What::PressedAtStart, &check_beside(rest, &begun));
    let other = &Camera::GOOD.record(std::iter::once(Motion::Shift { by_px: [400.0, 0.0] }))[0];
    expect_only(What::OtherSensor, &check_beside(other, &frames));
}

#[test]
fn images_in_another_order_than_their_depths_are_named() {
    let mut frames = press(Camera::GOOD, MIDDLE, 4.0);
    frames.swap(2, 5);
    for (number, frame) in frames.iter_mut().enumerate() {
        (frame.sequence, frame.capture_time_s) = (number as u64, number as f64 / 30.0);
    }
    expect_only(What::Order, &check(&frames));
}

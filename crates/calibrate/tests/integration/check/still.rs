use fingervision_calibrate::check::{RecordingCheck, STILL_IMAGES, StillCheck, What};
use fingervision_flow::FlowParams;
use fingervision_gel::Motion;
use fingervision_image::{Frame, Rect};

use super::rendered::{Camera, SIZE, expect_only, judged};

fn still(camera: Camera, motion: impl Fn(usize) -> Motion) -> Vec<Frame> {
    camera.record((0..STILL_IMAGES).map(motion))
}

fn check(frames: &[Frame]) -> RecordingCheck {
    let check = StillCheck::new(Rect::whole(SIZE.0, SIZE.1), true, &FlowParams::default()).unwrap();
    judged(Box::new(check), frames)
}

fn rest(_: usize) -> Motion {
    Motion::STILL
}

#[test]
fn a_gel_at_rest_passes_and_its_noise_is_measured() {
    let found = check(&still(Camera::GOOD, rest));
    assert!(found.is_sound(), "{found:?}");
    let noise = found.noise_levels.unwrap();
    assert!((noise - 2.0).abs() < 0.1, "{noise} levels instead of 2");
    assert!(found.deviation_px.unwrap() < 0.025 && found.motion_px.unwrap() < 0.01, "{found:?}");
}

#[test]
fn every_fault_of_a_still_recording_is_named_alone() {
    expect_only(What::Unsharp, &check(&still(Camera::BLURRED, rest)));
    expect_only(What::Unsharp, &check(&still(Camera::WITHOUT_PATTERN, rest)));
    expect_only(What::TooBright, &check(&still(Camera::OVEREXPOSED, rest)));
    expect_only(What::TooDark, &check(&still(Camera::DARK, rest)));
    expect_only(What::Count, &check(&still(Camera::GOOD, rest)[1..]));
    expect_only(What::Copies, &check(&vec![still(Camera::GOOD, rest)[0].clone(); STILL_IMAGES]));
    expect_only(What::Drift, &check(&still(Camera::GOOD, |number| Motion::shift(0.01 * number as f64))));
    let knocked = |number| Motion::Shift { by_px: [if number > 4 { 500.0 } else { 0.0 }, 0.0] };
    expect_only(What::Drift, &check(&still(Camera::GOOD, knocked)));
    let touched = |number| Motion::RadialBump {
        centre_px: [63.5, 47.5],
        radius_px: 15.0,
        amplitude_px: if number > 4 { 1.0 } else { 0.0 },
    };
    expect_only(What::Touched, &check(&still(Camera::GOOD, touched)));
}

#[test]
fn light_that_flickers_is_named() {
    let frames = still(Camera::GOOD, rest);
    let dimmer = still(Camera { gain: 0.94, ..Camera::GOOD }, rest);
    let mixed: Vec<Frame> = frames
        .into_iter()
        .zip(dimmer)
        .enumerate()
        .map(|(number, (a, b))| if number % 2 == 0 { a } else { b })
        .collect();
    expect_only(What::Light, &check(&mixed));
}

use fingervision_calibrate::camera::Slide;
use fingervision_calibrate::check::{BOARD_IMAGES, BoardCheck, RecordingCheck, What};
use fingervision_flow::FlowParams;
use fingervision_gel::Motion;
use fingervision_image::{Frame, Rect};

use super::rendered::{Camera, SIZE, expect_only, judged};

/// A board that slides along x by `step_px` per image.
fn slide(camera: Camera, step_px: f64) -> Vec<Frame> {
    camera.record((0..BOARD_IMAGES).map(|number| Motion::Shift { by_px: [step_px * number as f64, 0.0] }))
}

fn check(frames: &[Frame]) -> RecordingCheck {
    let slide = Slide { step_mm: 0.5, direction_rad: 0.0 };
    let check = BoardCheck::new(Rect::whole(SIZE.0, SIZE.1), true, &FlowParams::default(), slide).unwrap();
    judged(Box::new(check), frames)
}

#[test]
fn a_board_that_slides_in_steps_passes() {
    let found = check(&slide(Camera::GOOD, 4.0));
    assert!(found.is_sound(), "{found:?}");
    assert!((found.motion_px.unwrap() - 4.0).abs() < 0.02, "{found:?}");
}

#[test]
fn every_fault_of_a_board_is_named_alone() {
    expect_only(What::Unsharp, &check(&slide(Camera::BLURRED, 4.0)));
    expect_only(What::Unsharp, &check(&slide(Camera::WITHOUT_PATTERN, 4.0)));
    expect_only(What::TooBright, &check(&slide(Camera::OVEREXPOSED, 4.0)));
    expect_only(What::TooDark, &check(&slide(Camera::DARK, 4.0)));
    expect_only(What::StepTooSmall, &check(&slide(Camera::GOOD, 0.4)));
    expect_only(What::StepTooLarge, &check(&slide(Camera::GOOD, 35.0)));
    expect_only(What::StepTooLarge, &check(&slide(Camera::GOOD, 150.0)));
    expect_only(What::Direction, &check(&slide(Camera::GOOD, -4.0)));
    let good = slide(Camera::GOOD, 4.0);
    expect_only(What::Count, &check(&good[1..]));
    let mut swapped = good.clone();
    swapped.swap(8, 9);
    expect_only(What::UnevenSteps, &check(&swapped));
}

//! Presses with a known strain, and a network whose depth errs.

use super::*;

/// The shift after a press down to a depth, mm, in equal steps: the rigid motion lacks `lacks_mm`, the network errs by what
/// `error` gives for a depth.
fn pressed(steps: u32, deepest_mm: f64, lacks_mm: f64, error: impl Fn(f64) -> f64) -> FrozenStrain {
    let mut strain = FrozenStrain::new(10.0, 25.0);
    for step in 1..=steps {
        let depth_mm = deepest_mm * f64::from(step) / f64::from(steps);
        strain.begin();
        strain.compare(depth_mm - lacks_mm, depth_mm + error(depth_mm));
    }
    strain
}

#[test]
fn a_strain_is_found_whatever_its_sign_and_the_number_of_frames() {
    for steps in [20, 80, 400] {
        for lacks_mm in [-0.06, 0.06] {
            let shift = pressed(steps, 2.0, lacks_mm, |_| 0.0).shift();
            assert!((shift.mm - lacks_mm).abs() < 0.15 * lacks_mm.abs(), "{steps} frames: {shift:?} of {lacks_mm} mm");
            assert!(shift.deviation_mm < 0.025, "{steps} frames: {shift:?}");
        }
    }
}

#[test]
fn errors_of_the_network_hardly_move_a_face_without_strain() {
    for scale in [-0.1, -0.05, 0.05, 0.1] {
        let shift = pressed(20, 2.0, 0.0, |depth_mm| scale * depth_mm).shift();
        assert!(shift.mm.abs() < 0.008, "error of {scale} times the depth: {shift:?}");
    }
    let shift = pressed(20, 2.0, 0.0, |_| 0.01).shift();
    assert!(shift.mm.abs() < 0.004, "{shift:?}");
}

#[test]
fn a_single_deep_frame_says_nothing_and_the_deviation_says_so() {
    let shift = pressed(1, 2.0, 0.0, |depth_mm| 0.1 * depth_mm).shift();
    assert!(shift.mm.abs() < 0.01, "{shift:?}");
    assert!(shift.deviation_mm > 0.03, "{shift:?}");
    assert!(FrozenStrain::new(10.0, 25.0).shift().mm.abs() < 1e-12);
}

#[test]
fn a_press_that_is_held_or_raised_changes_nothing() {
    let mut strain = pressed(20, 1.0, 0.05, |_| 0.0);
    let shift = strain.shift();
    for frame in 0..1000 {
        strain.begin();
        let depth_mm = 1.0 - 0.0009 * f64::from(frame);
        strain.compare(depth_mm - 0.05, 0.9 * depth_mm);
        assert_eq!(strain.shift(), shift, "frame {frame}");
    }
}

#[test]
fn a_second_comparison_in_a_frame_replaces_the_first() {
    let mut twice = FrozenStrain::new(10.0, 25.0);
    let mut once = twice.clone();
    for step in 1..10 {
        let depth_mm = 0.1 * f64::from(step);
        twice.begin();
        twice.compare(depth_mm, 3.0 * depth_mm);
        twice.compare(depth_mm, depth_mm + 0.04);
        once.begin();
        once.compare(depth_mm, depth_mm + 0.04);
        assert_eq!(twice.shift(), once.shift(), "step {step}");
    }
}

#[test]
fn a_face_that_is_missed_twice_keeps_its_strain_and_one_that_slid_does_not() {
    let mut strain = pressed(20, 1.0, 0.05, |_| 0.0);
    let shift = strain.shift();
    for _ in 0..MOST_MISSED_FRAMES {
        strain.begin();
        assert_eq!(strain.shift(), shift);
    }
    strain.begin();
    assert!(strain.shift().mm.abs() < 1e-12);
}

#[test]
fn a_gel_that_is_scaled_as_a_whole_has_the_shift_scaled() {
    let mut small = FrozenStrain::new(5.0, 12.5);
    for step in 1..=20 {
        let depth_mm = 0.05 * f64::from(step);
        small.begin();
        small.compare(depth_mm - 0.02, depth_mm + 0.003);
    }
    let (small, large) = (small.shift(), pressed(20, 2.0, 0.04, |_| 0.006).shift());
    assert!((2.0 * small.mm - large.mm).abs() < 1e-12, "{small:?}, {large:?}");
    assert!((2.0 * small.deviation_mm - large.deviation_mm).abs() < 1e-12, "{small:?}, {large:?}");
}

#[test]
fn a_frame_that_is_discarded_leaves_nothing() {
    let (mut strain, mut other) = (pressed(5, 0.5, 0.05, |_| 0.0), pressed(5, 0.5, 0.05, |_| 0.0));
    strain.begin();
    strain.compare(1.0, 3.0);
    strain.discard();
    for strain in [&mut strain, &mut other] {
        strain.begin();
        strain.compare(0.55, 0.6);
    }
    assert_eq!(strain.shift(), other.shift());
}

//! A tracker that takes a new reference.

use fingervision_gel::{Light, Motion, Sheet, SheetRenderer};
use fingervision_image::{Frame, Image, Pixels};
use fingervision_touch::{Fields, Flag, Flags, Policy, Profile, Reading, Tracker};

const SIZE: (usize, usize) = (240, 180);
/// The frame that becomes the new reference.
const NEW: usize = 7;

/// A press in which a large area is hidden just before the new reference, so that every memory of earlier frames is in
/// use, then more of the press.
fn frames() -> Vec<Frame> {
    let sheet = Sheet { width: SIZE.0, height: SIZE.1, ..Sheet::default() };
    let renderers = [1, 77].map(|pattern_seed| SheetRenderer::new(&Sheet { pattern_seed, ..sheet.clone() }).unwrap());
    let bump = Motion::radial_bump(sheet.centre_px(), 6.0);
    let frame = |step: usize| {
        let motion = bump.at((step as f64 / 6.0).sin());
        let [seen, other] =
            [0, 1].map(|which: usize| renderers[which].render(&motion, Light::EVEN, step as u64).unwrap());
        let hidden = if (4..NEW).contains(&step) { SIZE.0 / 3 } else { 0 };
        let image = Image::from_fn(SIZE.0, SIZE.1, |x, y| if x < hidden { other.at(x, y) } else { seen.at(x, y) });
        Frame { sequence: step as u64, capture_time_s: step as f64 / 90.0, pixels: Pixels::Rgb8(image) }
    };
    (0..16).map(frame).collect()
}

fn tracker(policy: Policy) -> Tracker {
    let mut profile = Profile::default();
    profile.references.policy = policy;
    Tracker::new(&profile, SIZE, true, Fields::default()).unwrap()
}

/// Fails where two readings differ in more than the numbers that go on.
fn assert_same(re_zeroed: &Reading, fresh: &Reading) {
    assert_eq!(re_zeroed.flow, fresh.flow, "frame {}", fresh.sequence);
    assert_eq!(re_zeroed.deviation, fresh.deviation);
    assert_eq!((&re_zeroed.valid, &re_zeroed.density), (&fresh.valid, &fresh.density));
    assert_eq!(re_zeroed.reference_count, fresh.reference_count);
    assert_eq!(re_zeroed.photometric_error.to_bits(), fresh.photometric_error.to_bits());
    assert!(re_zeroed.reference_id > fresh.reference_id);
}

#[test]
fn a_tracker_with_a_new_reference_is_as_good_as_new() {
    let frames = frames();
    for policy in [Policy::Anchored, Policy::Single, Policy::Stack] {
        let (mut old, mut fresh) = (tracker(policy), tracker(policy));
        for frame in &frames[..NEW] {
            assert!(!old.track(frame).unwrap().flags.has(Flag::NewReference), "{policy:?}");
        }
        assert_eq!(old.reference_sequence(), Some(frames[0].sequence), "{policy:?}");
        old.rezero();
        for (step, frame) in frames[NEW..].iter().enumerate() {
            let (again, anew) = (old.track(frame).unwrap(), fresh.track(frame).unwrap());
            assert_same(again, anew);
            let mut expected = anew.flags;
            if step == 0 {
                expected.raise(Flag::NewReference);
            }
            assert_eq!(again.flags, expected, "{policy:?}, {step} frames after the new reference");
            assert_eq!(old.reference_sequence(), Some(frames[NEW].sequence), "{policy:?}");
        }
    }
}

#[test]
fn a_new_reference_before_the_first_frame_changes_nothing() {
    let frames = frames();
    let mut tracker = tracker(Policy::Anchored);
    tracker.rezero();
    let reading = tracker.track(&frames[0]).unwrap();
    assert_eq!((reading.flags, reading.reference_id), (Flags::default(), 0));
}

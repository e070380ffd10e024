//! The tracker on rendered streams with exact truth.

use fingervision_gel::{Light, Motion, Sheet, SheetRenderer};
use fingervision_image::{Frame, Image, Pixels};
use fingervision_touch::{DepthLine, Fields, Flag, Policy, Profile, Reading, TrackError, Tracker};

const SIZE: (usize, usize) = (240, 180);

/// Renders frames of one pattern.
struct Stage {
    renderer: SheetRenderer,
    centre: [f64; 2],
    next: u64,
}

impl Stage {
    fn new(pattern_seed: u64) -> Self {
        let sheet = Sheet { width: SIZE.0, height: SIZE.1, pattern_seed, ..Sheet::default() };
        Self { renderer: SheetRenderer::new(&sheet).unwrap(), centre: sheet.centre_px(), next: 0 }
    }

    fn bump(&self, amplitude_px: f64) -> Motion {
        Motion::radial_bump(self.centre, amplitude_px)
    }

    fn frame(&mut self, motion: &Motion, light: Light) -> Frame {
        let sequence = self.next;
        self.next += 1;
        let image = self.renderer.render(motion, light, 100 + sequence).unwrap();
        Frame { sequence, capture_time_s: sequence as f64 / 90.0, pixels: Pixels::Rgb8(image) }
    }
}

fn tracker(profile: &Profile) -> Tracker {
    Tracker::new(profile, SIZE, true, Fields::default()).unwrap()
}

fn calibrated() -> Profile {
    let mut profile = Profile::default();
    profile.depth.density = Some(DepthLine { slope_mm: 10.0, intercept_mm: 0.0 }.into());
    profile
}

/// Mean end-point error over the valid pixels farther than 16 px from the border.
fn mean_error(reading: &Reading, motion: &Motion) -> f32 {
    let truth = motion.flow(SIZE.0, SIZE.1);
    let (mut sum, mut count) = (0.0, 0);
    for y in 16..SIZE.1 - 16 {
        for x in 16..SIZE.0 - 16 {
            if reading.valid.at(x, y) == 1 {
                let (u, v) = (reading.flow.u.at(x, y), reading.flow.v.at(x, y));
                sum += (u - truth.u.at(x, y)).hypot(v - truth.v.at(x, y));
                count += 1;
            }
        }
    }
    assert!(count > 20_000, "only {count} pixels are valid");
    sum / count as f32
}

#[test]
fn a_press_and_its_release_are_followed() {
    for policy in [Policy::Anchored, Policy::Single, Policy::Stack] {
        let mut profile = calibrated();
        profile.references.policy = policy;
        let (mut stage, mut tracker) = (Stage::new(1), tracker(&profile));
        for step in 0..=8 {
            let motion = stage.bump(8.0).at(1.0 - (f64::from(step) / 4.0 - 1.0).abs());
            let frame = stage.frame(&motion, Light::EVEN);
            let reading = tracker.track(&frame).unwrap();
            let error = mean_error(reading, &motion);
            assert!(error < 0.04, "{policy:?}, frame {step}: off by {error} px");
            assert!(!reading.flags.has(Flag::Lost), "{policy:?}, frame {step}: {}", reading.flags);
        }
    }
}

#[test]
fn readings_that_are_taken_out_are_those_that_stay() {
    let (mut stage, profile) = (Stage::new(1), calibrated());
    let frames: Vec<Frame> = (0..6).map(|step| stage.frame(&stage.bump(f64::from(step)), Light::EVEN)).collect();
    let (mut keeping, mut giving) = (tracker(&profile), tracker(&profile));
    let (mut spare, mut allocations) = (None, 0);
    for frame in &frames {
        let kept = keeping.track(frame).unwrap();
        let mut taken = None;
        let measured = allocation_counter::measure(|| {
            giving.track(frame).unwrap();
            taken = Some(giving.take_reading(spare.take()));
        });
        allocations = measured.count_total;
        let taken = taken.unwrap();
        assert_eq!(taken.flow.u.values(), kept.flow.u.values());
        assert_eq!(taken.depth.as_ref().unwrap().values(), kept.depth.as_ref().unwrap().values());
        assert_eq!(taken.valid.values(), kept.valid.values());
        assert_eq!((taken.sequence, taken.max_depth_mm, taken.flags), (kept.sequence, kept.max_depth_mm, kept.flags));
        spare = Some(taken);
    }
    assert_eq!(allocations, 0, "the last frame");
    // The memory of another tracker's reading is of no use if its size differs.
    giving.take_reading(Some(Reading::new(8, 8)));
    let next = stage.frame(&stage.bump(2.0), Light::EVEN);
    assert_eq!(giving.track(&next).unwrap().flow.u.values(), keeping.track(&next).unwrap().flow.u.values());
}

#[test]
fn a_frame_allocates_nothing_once_the_references_stand() {
    let (mut stage, mut tracker) = (Stage::new(1), tracker(&calibrated()));
    let frames: Vec<Frame> = (0..30)
        .map(|step| {
            let motion = stage.bump(6.0).at((f64::from(step) / 6.0).sin().abs());
            stage.frame(&motion, Light::EVEN)
        })
        .collect();
    let (first, rest) = frames.split_at(2);
    for frame in first {
        tracker.track(frame).unwrap();
    }
    let allocations = allocation_counter::measure(|| {
        for frame in rest {
            tracker.track(frame).unwrap();
        }
    });
    assert_eq!(allocations.count_total, 0, "{allocations:?}");
}

#[test]
fn the_same_frames_give_the_same_bits() {
    let mut stage = Stage::new(1);
    let motions: Vec<Motion> = (0..6).map(|step| stage.bump(2.0 * f64::from(step))).collect();
    let frames: Vec<Frame> = motions.iter().map(|motion| stage.frame(motion, Light::EVEN)).collect();
    let (mut once, mut again) = (tracker(&calibrated()), tracker(&calibrated()));
    for frame in &frames {
        let (a, b) = (once.track(frame).unwrap(), again.track(frame).unwrap());
        let bits = |image: &Image<f32>| image.values().iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&a.flow.u), bits(&b.flow.u));
        assert_eq!(bits(a.depth.as_ref().unwrap()), bits(b.depth.as_ref().unwrap()));
        assert_eq!(a.valid, b.valid);
    }
}

#[test]
fn a_frame_of_something_else_is_lost_and_the_next_one_found_again() {
    let (mut stage, mut other, mut tracker) = (Stage::new(1), Stage::new(77), tracker(&calibrated()));
    let motion = stage.bump(5.0);
    for amplitude in [Motion::STILL, stage.bump(2.5), motion] {
        assert!(!tracker.track(&stage.frame(&amplitude, Light::EVEN)).unwrap().flags.has(Flag::Lost));
    }
    other.next = stage.next;
    let reading = tracker.track(&other.frame(&Motion::STILL, Light::EVEN)).unwrap();
    assert!(reading.flags.has(Flag::Lost), "{}", reading.flags);
    let valid = reading.valid.values().iter().map(|&valid| f64::from(valid)).sum::<f64>();
    assert!(valid < 0.3 * (SIZE.0 * SIZE.1) as f64, "{valid} pixels of something else count as valid");
    stage.next = other.next;
    let reading = tracker.track(&stage.frame(&motion, Light::EVEN)).unwrap();
    assert!(!reading.flags.has(Flag::Lost), "{}", reading.flags);
    assert!(mean_error(reading, &motion) < 0.04);
}

#[test]
fn a_start_under_pressure_is_flagged_and_its_rest_becomes_the_reference() {
    let mut profile = calibrated();
    profile.references.rest_frames = 5;
    let (mut stage, mut tracker) = (Stage::new(1), tracker(&profile));
    let press = stage.bump(6.0);
    for step in 0..4 {
        let frame = stage.frame(&press.at(1.0 - f64::from(step) / 3.0), Light::EVEN);
        let flags = tracker.track(&frame).unwrap().flags;
        assert_eq!(flags.has(Flag::PressedAtStart), step > 0, "frame {step}: {flags}");
    }
    let mut first_relative = None;
    for _ in 0..8 {
        let reading = tracker.track(&stage.frame(&Motion::STILL, Light::EVEN)).unwrap();
        if reading.flags.has(Flag::NewReference) {
            first_relative = Some(reading.sequence);
        }
    }
    assert_eq!(first_relative, tracker.reference_sequence().map(|reference| reference + 1), "the frame before it");
    let reading = tracker.track(&stage.frame(&Motion::STILL, Light::EVEN)).unwrap();
    assert!(!reading.flags.has(Flag::PressedAtStart), "{}", reading.flags);
    assert!(reading.reference_id > 0);
    assert!(mean_error(reading, &Motion::STILL) < 0.02);
}

#[test]
fn a_press_from_rest_is_not_taken_for_a_start_under_pressure() {
    let (mut stage, mut tracker) = (Stage::new(1), tracker(&calibrated()));
    for step in 0..8 {
        let motion = stage.bump(f64::from(step));
        let flags = tracker.track(&stage.frame(&motion, Light::EVEN)).unwrap().flags;
        assert!(!flags.has(Flag::PressedAtStart), "frame {step}: {flags}");
    }
}

#[test]
fn light_may_change_by_a_half_and_is_flagged() {
    let (mut stage, mut tracker) = (Stage::new(1), tracker(&calibrated()));
    let motion = stage.bump(4.0);
    tracker.track(&stage.frame(&Motion::STILL, Light::EVEN)).unwrap();
    let frame = stage.frame(&motion, Light::uniform(0.5));
    let reading = tracker.track(&frame).unwrap();
    assert!(reading.flags.has(Flag::LightChanged), "{}", reading.flags);
    let error = mean_error(reading, &motion);
    assert!(error < 0.05, "off by {error} px");
}

#[test]
fn a_jump_is_found_again_by_the_search() {
    let (mut stage, mut tracker) = (Stage::new(1), tracker(&calibrated()));
    tracker.track(&stage.frame(&Motion::STILL, Light::EVEN)).unwrap();
    let motion = Motion::shift(24.0);
    let frame = stage.frame(&motion, Light::EVEN);
    let error = mean_error(tracker.track(&frame).unwrap(), &motion);
    assert!(error < 0.02, "off by {error} px");
}

#[test]
fn frames_out_of_order_and_of_another_size_are_refused_and_the_next_is_taken() {
    let (mut stage, mut tracker) = (Stage::new(1), tracker(&calibrated()));
    let frames: Vec<Frame> = (0..4).map(|_| stage.frame(&Motion::STILL, Light::EVEN)).collect();
    tracker.track(&frames[1]).unwrap();
    let error = tracker.track(&frames[0]).unwrap_err();
    assert!(matches!(error, TrackError::OutOfOrder { sequence: 0, previous: 1, .. }), "{error}");
    assert!(error.hint().is_some());
    let small = Frame { pixels: Pixels::Grey8(Image::filled(64, 48, 0)), ..frames[2].clone() };
    let error = tracker.track(&small).unwrap_err();
    assert!(error.to_string().contains("64x48"), "{error}");
    let reading = tracker.track(&frames[3]).unwrap();
    assert_eq!(reading.dropped_frames, 1);
    assert!(reading.flags.has(Flag::Dropped));
}

#[test]
fn a_slope_per_position_is_that_of_the_camera() {
    let mut profile = calibrated();
    profile
        .set_all([
            ("camera.focal_length_px", "[200, 200]"),
            ("camera.principal_point_px", "[119.5, 89.5]"),
            ("camera.translation_mm", "[0, 0, 20]"),
            ("depth.density", "{ gain = 0.5 }"),
        ])
        .unwrap();
    let (mut stage, mut tracker) = (Stage::new(1), tracker(&profile));
    tracker.track(&stage.frame(&Motion::STILL, Light::EVEN)).unwrap();
    let bumps = [4.0, 6.0].map(|amplitude| stage.bump(amplitude));
    let frames = bumps.map(|bump| stage.frame(&bump, Light::EVEN));
    tracker.track(&frames[0]).unwrap();
    let allocations = allocation_counter::measure(|| {
        tracker.track(&frames[1]).unwrap();
    });
    assert_eq!(allocations.count_total, 0, "{allocations:?}");
    let last = stage.bump(5.0);
    let reading = tracker.track(&stage.frame(&last, Light::EVEN)).unwrap();
    let (feature, depth) = (reading.density.as_ref().unwrap(), reading.depth.as_ref().unwrap());
    for (depth, feature) in depth.values().iter().zip(feature.values()) {
        assert!((depth - 5.0 * feature).abs() < 1e-5, "{depth} mm for a feature of {feature}");
    }
}

#[test]
fn fields_that_were_not_asked_for_are_absent() {
    let mut stage = Stage::new(1);
    let fields = Fields::NONE;
    let mut tracker = Tracker::new(&calibrated(), SIZE, true, fields).unwrap();
    let frame = stage.frame(&Motion::STILL, Light::EVEN);
    let reading = tracker.track(&frame).unwrap();
    assert!(reading.density.is_none() && reading.depth.is_none() && reading.max_depth_mm.is_none());
}

//! From images of simulated presses to depth, force and flags.

use fingervision_elastic::GelBlock;
use fingervision_gel::{Scene, Simulation};
use fingervision_image::{Frame, Pixels};
use fingervision_touch::{ElasticMode, Fields, Flag, Profile, Reading, Team, Tracker};

use crate::solved::solve;

const FIELDS: Fields = Fields { depth: true, traction: true, ..Fields::NONE };

/// A press on the draft mesh, and a tracker with the profile of its gel and camera.
pub(crate) struct Press {
    simulation: Simulation,
    profile: Profile,
    sequence: u64,
}

impl Press {
    pub(crate) fn new(scene: &str) -> Self {
        let scene = Scene::from_toml(&format!("name = 'press'\n{scene}\n[mesh]\nresolution = 'draft'\n")).unwrap();
        let mut simulation = Simulation::new(&scene).unwrap();
        solve(&mut simulation);
        let profile = Profile { camera: Some(scene.camera()), gel: Some(scene.gel), ..Profile::default() };
        Self { simulation, profile, sequence: 0 }
    }

    /// A ball of radius 6 mm, pressed down to a depth, mm, in eight steps.
    fn of_a_ball(gel: &str, depth_mm: f64) -> Self {
        Self::new(&format!(
            "[gel]\n{gel}\n[contact]\nlaw = 'frictionless'\n[indenter]\nshape = 'sphere'\nradius_mm = 6.0\n\
             [motion]\nframes = 9\nkeyframes = [{{ at = 8, depth_mm = {depth_mm:.1} }}]"
        ))
    }

    /// A flat circle, under which the gel is strained when it begins to stick, pressed down in eight steps.
    fn that_sticks_late() -> Self {
        Self::new(
            "[gel]\npoissons_ratio = 0.35\n[contact]\nlaw = 'late-stick'\n[indenter]\nshape = 'circle'\nradius_mm = 4.0\n\
             [motion]\nframes = 9\nkeyframes = [{ at = 8, depth_mm = 0.8 }]",
        )
    }

    pub(crate) fn tracker(&self) -> Tracker {
        Tracker::new(&self.profile, self.simulation.size(), true, FIELDS).unwrap()
    }

    /// Tracks a pose of the press.
    fn show<'a>(&mut self, pose: usize, tracker: &'a mut Tracker) -> &'a Reading {
        tracker.track(&self.frame(pose)).unwrap()
    }

    pub(crate) fn frame(&mut self, pose: usize) -> Frame {
        let pixels: Pixels = self.simulation.frame(pose).unwrap().clone();
        let (sequence, capture_time_s) = (self.sequence, self.sequence as f64 / 90.0);
        self.sequence += 1;
        Frame { sequence, capture_time_s, pixels }
    }

    /// Tracks the whole press.
    fn show_all<'a>(&mut self, tracker: &'a mut Tracker) -> &'a Reading {
        for pose in 0..8 {
            self.show(pose, tracker);
        }
        self.show(8, tracker)
    }
}

/// Pixels in contact.
fn touched(reading: &Reading) -> usize {
    reading.contact.as_ref().unwrap().values().iter().map(|&contact| usize::from(contact)).sum()
}

#[test]
fn depth_and_force_of_a_press_are_found_from_its_images() {
    let mut press = Press::of_a_ball("", 1.6);
    let mut tracker = press.tracker();
    let reading = press.show_all(&mut tracker).clone();
    let truth = press.simulation.truth(8).unwrap();
    let depths = reading.depth.as_ref().unwrap().values().iter().zip(truth.depth.values());
    let error_mm = depths.map(|(found, truth)| f64::from((found - truth).abs())).sum::<f64>() / (480.0 * 480.0);
    assert!(error_mm < 0.012, "{error_mm} mm");
    let deepest_mm = reading.max_depth_mm.unwrap();
    assert!((deepest_mm - 1.6).abs() < 0.15, "{deepest_mm} mm deep");
    let ([_, _, force_n], true_n) = (reading.force_n.unwrap(), press.simulation.states()[8].force_n[2]);
    assert!((f64::from(force_n) - true_n).abs() < 0.1 * true_n, "{force_n} N, {true_n} N in truth");
    assert_eq!(reading.flags.to_string(), "");
}

/// The strain that gel has when it begins to stick looks like depth. It is found, or the deviation includes it.
#[test]
fn the_depth_of_a_face_that_sticks_late_is_right_or_its_deviation_says_so() {
    let mut press = Press::that_sticks_late();
    let true_mm = press.simulation.truth(8).unwrap().depth.clone();
    let mut errors = |poses: &[usize]| {
        let mut tracker = press.tracker();
        for &pose in poses {
            press.show(pose, &mut tracker);
        }
        let reading = tracker.reading();
        let (depth, deviation) = (reading.depth.as_ref().unwrap(), reading.depth_deviation.as_ref().unwrap());
        let middle = (0..480 * 480_usize).filter(|pixel| {
            let [x, y] = [pixel % 480, pixel / 480].map(|at| at.abs_diff(240));
            x * x + y * y < 48 * 48
        });
        let errors = middle.map(|at| (depth.values()[at] - true_mm.values()[at], deviation.values()[at]));
        let (sum, deviations, count) =
            errors.fold((0.0, 0.0, 0.0), |sum, (error, deviation)| (sum.0 + error, sum.1 + deviation, sum.2 + 1.0));
        (sum / count, deviations / count)
    };
    let (slow_mm, known_to_mm) = errors(&[0, 1, 2, 3, 4, 5, 6, 7, 8]);
    assert!(slow_mm.abs() < 0.025, "{slow_mm} mm");
    let (at_once_mm, less_well_mm) = errors(&[0, 8]);
    assert!(at_once_mm < -0.03, "{at_once_mm} mm: this press shows too little depth");
    assert!(less_well_mm > known_to_mm && at_once_mm.abs() < 2.0 * less_well_mm, "{at_once_mm} mm, {less_well_mm} mm");
}

#[test]
fn a_light_touch_is_felt_and_noise_is_not() {
    let mut press = Press::of_a_ball("", 0.3);
    let mut tracker = press.tracker();
    for _ in 0..5 {
        let reading = press.show(0, &mut tracker);
        assert_eq!((reading.contact_area_mm2, reading.force_n), (Some(0.0), Some([0.0; 3])));
    }
    let ([_, _, force_n], true_n) =
        (press.show_all(&mut tracker).force_n.unwrap(), press.simulation.states()[8].force_n[2]);
    assert!(true_n < 0.6, "{true_n} N is no light touch");
    assert!((f64::from(force_n) - true_n).abs() < 0.3 * true_n, "{force_n} N, {true_n} N in truth");
}

/// A gel that is pressed at the start and then pressed harder looks like one that was at rest, until it is released.
#[test]
fn a_release_after_a_harder_press_shows_that_the_gel_was_pressed_at_the_start() {
    let mut press = Press::of_a_ball("", 1.6);
    press.profile.references.rest_frames = 4;
    let mut tracker = press.tracker();
    for pose in [3, 4, 5, 6, 7, 8, 8, 8, 8, 8, 8] {
        assert!(!press.show(pose, &mut tracker).flags.has(Flag::PressedAtStart), "pose {pose}");
    }
    for pose in [6, 3, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0] {
        press.show(pose, &mut tracker);
    }
    assert!(tracker.reading().flags.has(Flag::PressedAtStart), "{}", tracker.reading().flags);
    // Only a new reference ends it.
    assert!(press.show_all(&mut tracker).flags.has(Flag::PressedAtStart));
    tracker.rezero();
    press.show(0, &mut tracker);
    let reading = press.show_all(&mut tracker);
    assert!(!reading.flags.has(Flag::PressedAtStart), "{}", reading.flags);
}

#[test]
fn a_press_on_compressible_gel_is_not_taken_for_a_release() {
    let mut press = Press::of_a_ball("poissons_ratio = 0.35", 1.6);
    press.profile.references.rest_frames = 4;
    let gel = press.profile.gel.take();
    let mut blind = press.tracker();
    assert!(!press.show_all(&mut blind).flags.has(Flag::PressedAtStart), "without camera and gel it may be either");
    press.profile.gel = gel;
    let mut tracker = press.tracker();
    let pressed = press.show_all(&mut tracker).clone();
    assert_eq!(pressed.flags.to_string(), "");
    for _ in 0..8 {
        press.show(8, &mut tracker);
    }
    let held = press.show(8, &mut tracker);
    assert_eq!(held.reference_id, 0);
    let (before, now) = (pressed.max_depth_mm.unwrap(), held.max_depth_mm.unwrap());
    assert!((now - before).abs() < 0.05, "{before} mm, then {now} mm");
}

#[test]
fn a_gel_that_is_released_takes_its_rest_for_the_reference() {
    let mut press = Press::of_a_ball("", 1.6);
    press.profile.references.rest_frames = 4;
    let mut tracker = press.tracker();
    for pose in (0..=8).rev() {
        press.show(pose, &mut tracker);
    }
    for _ in 0..8 {
        press.show(0, &mut tracker);
    }
    let reading = press.show(0, &mut tracker);
    assert!(reading.reference_id > 0 && reading.flags.to_string().is_empty(), "{}", reading.flags);
    assert_eq!(reading.contact_area_mm2, Some(0.0));
}

#[test]
fn a_re_zeroed_tracker_gives_the_depth_and_force_of_a_new_one() {
    for mode in ["live", "exact"] {
        let mut press = Press::of_a_ball("", 1.6);
        press.profile.set("elastic.mode", mode).unwrap();
        let (mut old, mut fresh) = (press.tracker(), press.tracker());
        for pose in 2..8 {
            press.show(pose, &mut old);
        }
        old.rezero();
        for pose in [2, 4, 6, 8] {
            let frame = press.frame(pose);
            let (again, anew) = (old.track(&frame).unwrap(), fresh.track(&frame).unwrap());
            assert_eq!((&again.depth, &again.contact), (&anew.depth, &anew.contact), "{mode}, pose {pose}");
            assert_eq!((again.force_n, again.torque_nmm), (anew.force_n, anew.torque_nmm), "{mode}, pose {pose}");
            assert_eq!(again.flags.has(Flag::NewReference), pose == 2);
        }
        assert!(old.reading().force_n.unwrap()[2] > 1.0, "{mode}: {:?}", old.reading().force_n);
    }
}

/// What was found in one press is not used in the next, whether the gel came to rest or the tracker was re-zeroed.
#[test]
fn the_strain_of_a_face_does_not_outlive_its_press() {
    for mode in ["live", "exact"] {
        let mut press = Press::that_sticks_late();
        press.profile.set("elastic.mode", mode).unwrap();
        let (mut rested, mut zeroed, mut fresh) = (press.tracker(), press.tracker(), press.tracker());
        for pose in 0..=8 {
            press.show(pose, &mut rested);
            press.show(pose, &mut zeroed);
        }
        press.show(0, &mut rested);
        zeroed.rezero();
        let frames = [0, 4, 8].map(|pose| press.frame(pose));
        for frame in &frames {
            fresh.track(frame).unwrap();
            zeroed.track(frame).unwrap();
        }
        for frame in &frames[1..] {
            rested.track(frame).unwrap();
        }
        let depths = [&rested, &fresh].map(|tracker| {
            let reading = tracker.reading();
            let at = 240 * 480 + 240;
            [&reading.depth, &reading.depth_deviation].map(|plane| plane.as_ref().unwrap().values()[at])
        });
        assert!(zeroed.reading().depth == fresh.reading().depth, "{mode}: re-zeroed");
        assert!(zeroed.reading().depth_deviation == fresh.reading().depth_deviation, "{mode}: re-zeroed");
        for (rested, fresh) in depths[0].iter().zip(depths[1]) {
            assert!((rested - fresh).abs() < 1e-3, "{mode}: {depths:?} mm");
        }
        // A tracker that still used the strain of the first press would give 0.025 mm.
        assert!(
            fresh.reading().depth_deviation.as_ref().unwrap().values()[240 * 480 + 240] > 0.03,
            "{mode}: {depths:?}"
        );
    }
}

#[test]
fn a_press_beyond_a_quarter_of_the_thickness_is_flagged() {
    let mut press = Press::of_a_ball("thickness_mm = 8.0", 2.4);
    let mut tracker = press.tracker();
    let mut is_flagged = |pose| press.show(pose, &mut tracker).flags.has(Flag::BeyondLinear);
    let flagged: Vec<_> = (0..=8).map(&mut is_flagged).collect();
    assert!(!flagged[..6].contains(&true) && flagged[8], "{flagged:?}, from 2 mm on it should be");
}

#[test]
fn contact_at_the_border_of_the_view_is_flagged_and_its_visible_part_is_reported() {
    let mut press = Press::of_a_ball("", 1.6);
    let size = press.simulation.size();
    let mut whole = press.tracker();
    press.show_all(&mut whole);
    let (whole_n, whole_px) = (whole.reading().force_n.unwrap()[2], touched(whole.reading()));
    press.profile.set("image.region_of_interest", &format!("[0, 0, {}, {}]", size.0 / 2, size.1)).unwrap();
    let mut tracker = press.tracker();
    let reading = press.show_all(&mut tracker);
    assert!(reading.flags.has(Flag::ContactCut), "{}", reading.flags);
    let seen_px = touched(reading);
    assert!((2 * seen_px).abs_diff(whole_px) < whole_px / 5, "{seen_px} px of {whole_px}: half of it is seen");
    let (area, pixel) = (reading.contact_area_mm2.unwrap(), 0.0625_f32.powi(2));
    assert!((area - pixel * seen_px as f32).abs() < 0.1 * area, "{area} mm² in {seen_px} px");
    let part = reading.force_n.unwrap()[2] / whole_n;
    assert!((0.3..1.0).contains(&part), "{part} of the force");
}

#[test]
fn a_gel_outside_the_training_range_is_flagged_once_it_moves() {
    let mut press = Press::of_a_ball("thickness_mm = 5.0", 0.8);
    let mut tracker = press.tracker();
    assert_eq!(press.show(0, &mut tracker).flags.to_string(), "");
    let reading = press.show_all(&mut tracker);
    assert!(reading.flags.has(Flag::OutsideTraining), "{}", reading.flags);
    press.profile.elastic.network = false;
    let mut tracker = press.tracker();
    let reading = press.show_all(&mut tracker);
    assert!(!reading.flags.has(Flag::OutsideTraining), "it was not asked for: {}", reading.flags);
}

/// A sensor of half or twice the size gives the same images. Its depths scale with it, its forces with its square, and its
/// flags are the same: no threshold is a length in mm.
#[test]
fn a_scaled_sensor_gives_scaled_depths_and_the_same_flags() {
    let square = "[contact]\nlaw = 'stick'\n[indenter]\nshape = 'rectangle'\nsize_mm = [6.0, 6.0]\n\
                  [motion]\nframes = 9\nkeyframes = [{ at = 8, depth_mm = 1.2 }]";
    for (mut press, learned) in
        [(Press::of_a_ball("", 0.3), true), (Press::of_a_ball("", 2.6), true), (Press::new(square), false)]
    {
        press.profile.elastic.network = learned;
        let camera = press.profile.camera.unwrap();
        let gel = press.profile.gel.unwrap();
        let frames = [0, 2, 4, 6, 8].map(|pose| press.frame(pose));
        let mut readings = [1.0, 0.5, 2.0].map(|scale| {
            let mut camera = camera;
            camera.translation_mm = camera.translation_mm.map(|length| length * scale);
            press.profile.camera = Some(camera);
            press.profile.gel = Some(GelBlock {
                size_mm: gel.size_mm.map(|length| length * scale),
                thickness_mm: gel.thickness_mm * scale,
                ..gel
            });
            let mut tracker = press.tracker();
            for frame in &frames {
                tracker.track(frame).unwrap();
            }
            (scale, tracker.reading().clone())
        });
        let (_, whole) = readings[0].clone();
        assert!(whole.max_depth_mm.unwrap() > 0.2);
        for (scale, reading) in &mut readings[1..] {
            assert_eq!(reading.flags, whole.flags);
            let same = |found: f32, expected: f32, scale: f64| {
                let found = f64::from(found) / scale;
                assert!((found - f64::from(expected)).abs() <= 1e-3 * f64::from(expected).abs(), "{found}, {expected}");
            };
            same(reading.max_depth_mm.unwrap(), whole.max_depth_mm.unwrap(), *scale);
            same(reading.contact_area_mm2.unwrap(), whole.contact_area_mm2.unwrap(), scale.powi(2));
            same(reading.force_n.unwrap()[2], whole.force_n.unwrap()[2], scale.powi(2));
            let (depths, expected) = (reading.depth.as_ref().unwrap(), whole.depth.as_ref().unwrap());
            let deepest = f64::from(whole.max_depth_mm.unwrap());
            for (found, expected) in depths.values().iter().zip(expected.values()) {
                let difference = f64::from(*found) / *scale - f64::from(*expected);
                assert!(difference.abs() <= 1e-3 * deepest, "{found} mm at scale {scale}, {expected} mm");
            }
            let [found, expected] = [&*reading, &whole].map(|reading| reading.depth_deviation.as_ref().unwrap());
            let both = found.values().iter().zip(expected.values()).filter(|(_, expected)| expected.is_finite());
            both.for_each(|(found, expected)| same(*found, *expected, *scale));
        }
    }
}

#[test]
fn threads_that_share_a_frame_give_the_same_bits() {
    let mut press = Press::of_a_ball("poissons_ratio = 0.48", 1.5);
    let team = Team::new(2).unwrap();
    for mode in [ElasticMode::Live, ElasticMode::Exact] {
        press.profile.elastic.mode = mode;
        let (mut alone, mut shared) = (press.tracker(), press.tracker());
        shared.share(&team);
        for pose in 0..9 {
            let frame = press.frame(pose);
            let (alone, shared) = (alone.track(&frame).unwrap(), shared.track(&frame).unwrap());
            assert_eq!(shared.flow, alone.flow, "pose {pose}");
            assert_eq!(shared.depth, alone.depth, "pose {pose}");
            assert_eq!(shared.depth_deviation, alone.depth_deviation, "pose {pose}");
            assert_eq!(shared.contact, alone.contact, "pose {pose}");
            assert_eq!(shared.traction, alone.traction, "pose {pose}");
            assert_eq!(shared.numbers.force_n, alone.numbers.force_n, "pose {pose}");
            assert!(pose < 8 || alone.max_depth_mm.is_some_and(|depth_mm| depth_mm > 1.0), "the ball presses");
        }
    }
}

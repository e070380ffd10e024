//! Flags that say when a reading cannot be trusted: light, drift, damage, lost and found.

use fingervision_gel::{Light, Motion, Sheet, SheetRenderer};
use fingervision_image::{Frame, Image, Pixels, Rect, grey_into};
use fingervision_touch::{Fields, Fingerprint, Flag, Flags, Profile, Tracker};

const SIZE: (usize, usize) = (240, 180);
/// Frames per second: slow, so that minutes take few frames.
const RATE: f64 = 5.0;

/// Shows a sheet to a tracker.
struct Stage {
    sheet: Sheet,
    renderer: SheetRenderer,
    tracker: Tracker,
    next: u64,
}

impl Stage {
    fn new(setting: Option<(&str, &str)>) -> Self {
        let sheet = Sheet { width: SIZE.0, height: SIZE.1, ..Sheet::default() };
        let mut profile = Profile::default();
        profile.set_all(setting).unwrap();
        let tracker = Tracker::new(&profile, SIZE, true, Fields::NONE).unwrap();
        Self { renderer: SheetRenderer::new(&sheet).unwrap(), sheet, tracker, next: 0 }
    }

    fn render(&self, motion: &Motion) -> Image<[u8; 3]> {
        self.renderer.render(motion, Light::EVEN, self.next).unwrap()
    }

    fn show(&mut self, image: Image<[u8; 3]>) -> Flags {
        let (sequence, capture_time_s) = (self.next, self.next as f64 / RATE);
        self.next += 1;
        self.tracker.track(&Frame { sequence, capture_time_s, pixels: Pixels::Rgb8(image) }).unwrap().flags
    }

    fn show_motion(&mut self, motion: &Motion) -> Flags {
        self.show(self.render(motion))
    }

    fn bump(&self, amplitude_px: f64) -> Motion {
        Motion::radial_bump(self.sheet.centre_px(), amplitude_px)
    }
}

fn brightened(image: &Image<[u8; 3]>, factor: f32) -> Image<[u8; 3]> {
    Image::from_fn(SIZE.0, SIZE.1, |x, y| image.at(x, y).map(|level| (f32::from(level) * factor).min(255.0) as u8))
}

#[test]
fn too_much_and_too_little_light_are_flagged_as_long_as_they_last() {
    let mut stage = Stage::new(None);
    let image = stage.render(&Motion::STILL);
    for (factor, is_saturated, is_dark) in
        [(1.0, false, false), (2.5, true, false), (1.0, false, false), (0.1, false, true), (0.8, false, false)]
    {
        let flags = stage.show(brightened(&image, factor));
        let found = (flags.has(Flag::Saturated), flags.has(Flag::Dark));
        assert_eq!(found, (is_saturated, is_dark), "light times {factor}: {flags}");
    }
}

#[test]
fn level_saturation_and_sharpness_of_every_image_are_measured() {
    let mut stage = Stage::new(None);
    let image = stage.render(&Motion::STILL);
    let mut numbers = |factor| {
        stage.show(brightened(&image, factor));
        stage.tracker.reading().numbers
    };
    let (bright, half, clipped) = (numbers(1.0), numbers(0.5), numbers(2.5));
    assert!((half.mean_level / bright.mean_level - 0.5).abs() < 0.01, "{half:?} {bright:?}");
    assert!((half.sharpness / bright.sharpness - 1.0).abs() < 0.02, "{half:?} {bright:?}");
    assert!(half.saturated_part <= 0.0 && clipped.saturated_part > 0.3, "{half:?} {clipped:?}");
}

#[test]
fn a_first_image_without_light_is_flagged() {
    let mut stage = Stage::new(None);
    let black = Image::from_fn(SIZE.0, SIZE.1, |x, y| [((x * 7 + y * 13) % 5) as u8; 3]);
    assert!(stage.show(black).has(Flag::Dark));
}

#[test]
fn the_first_reading_after_a_loss_is_flagged() {
    let mut stage = Stage::new(None);
    let seen = stage.render(&Motion::STILL);
    let hidden = Image::filled(SIZE.0, SIZE.1, [90, 90, 90]);
    let images = [seen.clone(), hidden.clone(), hidden, seen.clone(), seen];
    let flags = images.map(|image| stage.show(image));
    assert_eq!(flags.map(|flags| flags.has(Flag::Lost)), [false, true, true, false, false], "{flags:?}");
    assert_eq!(flags.map(|flags| flags.has(Flag::Found)), [false, false, false, true, false], "{flags:?}");
}

#[test]
fn a_slow_shift_is_drift_and_a_press_that_is_held_is_not() {
    let mut stage = Stage::new(None);
    // A press within a second, held for a minute, then released.
    for step in 0..320_u32 {
        let part = f64::from(step.min(310 - step.min(310)).min(5)) / 5.0;
        let flags = stage.show_motion(&stage.bump(5.0).at(part));
        assert!(!flags.has(Flag::Drift), "frame {step}: {flags}");
    }
    // A shift of 0.015 px/s.
    let drifted: Vec<bool> =
        (0..150_u32).map(|step| stage.show_motion(&Motion::shift(0.003 * f64::from(step))).has(Flag::Drift)).collect();
    let first = drifted.iter().position(|drifted| *drifted).unwrap();
    let shift_px = 0.003 * first as f64;
    assert!((0.24..0.30).contains(&shift_px), "flagged at {shift_px} px");
    assert!(drifted[first..].iter().all(|drifted| *drifted));
}

#[test]
fn a_worn_pattern_ages_the_reference() {
    let mut stage = Stage::new(None);
    let other = SheetRenderer::new(&Sheet { pattern_seed: 7, ..stage.sheet.clone() }).unwrap();
    let other = other.render(&Motion::STILL, Light::EVEN, 1).unwrap();
    let mut show = |worn: f32| {
        let image = stage.render(&Motion::STILL);
        let mix = |(new, old): (u8, u8)| (f32::from(old) + worn * (f32::from(new) - f32::from(old))) as u8;
        let worn = |x, y| {
            let ([r, g, b], [or, og, ob]) = (other.at(x, y), image.at(x, y));
            [(r, or), (g, og), (b, ob)].map(mix)
        };
        stage.show(Image::from_fn(SIZE.0, SIZE.1, worn)).has(Flag::Drift)
    };
    assert!((0..60).all(|_| !show(0.0)));
    let aged: Vec<bool> = (0..150_u16).map(|step| show(f32::from(step) / 500.0)).collect();
    assert!(!aged[0] && aged[149], "{aged:?}");
}

#[test]
fn a_drifted_reference_is_replaced_by_rule_and_flagged() {
    for (rule, is_replaced) in [(None, false), (Some(("references.rezero_after_s", "6.0")), true)] {
        let mut stage = Stage::new(rule);
        let shift = |step: u32| Motion::shift(0.003 * f64::from(step.min(120)));
        let flags: Vec<Flags> = (0..200).map(|step| stage.show_motion(&shift(step))).collect();
        let first = flags.iter().position(|flags| flags.has(Flag::Drift)).unwrap();
        let replaced: Vec<usize> = (0..flags.len()).filter(|&frame| flags[frame].has(Flag::NewReference)).collect();
        assert_eq!(replaced.len(), usize::from(is_replaced), "{replaced:?}");
        for frame in replaced {
            assert!(frame > first && !flags[frame..].iter().any(|flags| flags.has(Flag::Drift)));
        }
    }
}

#[test]
fn another_sensor_than_the_profile_s_is_flagged_in_every_reading() {
    let sheet = Sheet { width: SIZE.0, height: SIZE.1, ..Sheet::default() };
    let mut known = Image::filled(SIZE.0, SIZE.1, 0.0);
    let image = SheetRenderer::new(&sheet).unwrap().render(&Motion::STILL, Light::EVEN, 1).unwrap();
    grey_into(&Pixels::Rgb8(image), Rect::whole(SIZE.0, SIZE.1), &mut known).unwrap();
    let text = format!("'{}'", String::from(Fingerprint::of(&known).unwrap()));
    for (pattern_seed, is_other) in [(sheet.pattern_seed, false), (99, true)] {
        let mut stage = Stage::new(Some(("pattern.fingerprint", &text)));
        stage.renderer = SheetRenderer::new(&Sheet { pattern_seed, ..sheet.clone() }).unwrap();
        let black = Image::filled(SIZE.0, SIZE.1, [3; 3]);
        assert!(!stage.show(black).has(Flag::OtherSensor), "too dark to tell");
        stage.tracker.rezero();
        for step in 0..4 {
            let flags = stage.show_motion(&stage.bump(f64::from(step)));
            assert_eq!(flags.has(Flag::OtherSensor), is_other, "frame {step}: {flags}");
        }
    }
}

#[test]
fn damaged_gel_is_flagged_with_its_share() {
    let mut stage = Stage::new(None);
    for _ in 0..3 {
        assert_eq!(stage.show_motion(&Motion::STILL), Flags::default());
    }
    let tear = |image: &Image<[u8; 3]>| {
        Image::from_fn(SIZE.0, SIZE.1, |x, y| {
            if (64..112).contains(&x) && (64..96).contains(&y) { [20, 20, 20] } else { image.at(x, y) }
        })
    };
    let flags: Vec<Flags> = (0..60).map(|_| stage.show(tear(&stage.render(&Motion::STILL)))).collect();
    assert!(!flags[0].has(Flag::GelDamaged) && flags[59].has(Flag::GelDamaged), "{flags:?}");
    let part = stage.tracker.reading().damaged_part;
    let torn = (48 * 32) as f32 / (SIZE.0 * SIZE.1) as f32;
    assert!((0.3 * torn..3.0 * torn).contains(&part), "{part} of the image, {torn} in truth");
}

/// Opaque specks on the optics, the same in every image.
fn with_specks(mut image: Image<[u8; 3]>) -> Image<[u8; 3]> {
    for (centre_x, centre_y) in [(90_usize, 70_usize), (150, 60), (120, 110), (70, 120), (170, 115)] {
        for y in centre_y - 6..=centre_y + 6 {
            for x in centre_x - 6..=centre_x + 6 {
                if x.abs_diff(centre_x).pow(2) + y.abs_diff(centre_y).pow(2) <= 30 {
                    image.row_mut(y)[x] = [30; 3];
                }
            }
        }
    }
    image
}

#[test]
fn specks_on_the_optics_are_flagged_once_the_gel_moves_behind_them() {
    for (has_specks, grows) in [(true, true), (false, true), (true, false)] {
        let mut stage = Stage::new(None);
        let mut flags = Flags::default();
        for frame in 0..8 {
            let motion = Motion::Shift { by_px: if grows { [0.8 * f64::from(frame), 0.3] } else { [0.0; 2] } };
            let image = stage.render(&motion);
            flags = stage.show(if has_specks { with_specks(image) } else { image });
        }
        let reading = stage.tracker.reading();
        assert_eq!(flags.has(Flag::GelDamaged), has_specks && grows, "{has_specks} {grows}: {flags}");
        if has_specks && grows {
            assert!((0.01..0.2).contains(&reading.numbers.damaged_part), "{}", reading.numbers.damaged_part);
            assert_eq!(reading.valid.at(120, 110), 0, "the flow of a speck is not valid");
            let moves_px = reading.flow.u.at(120, 110);
            assert!((moves_px - 5.6).abs() < 0.3, "the gel behind a speck moves by {moves_px} px instead of 5.6");
        }
    }
}

#[test]
fn a_new_reference_forgets_the_specks_of_the_last_one() {
    let mut stage = Stage::new(None);
    let path = |frame: i32| Motion::Shift { by_px: [0.8 * f64::from(frame), 0.3] };
    let show = |stage: &mut Stage, frame| {
        let image = with_specks(stage.render(&path(frame)));
        stage.show(image)
    };
    for frame in 0..6 {
        show(&mut stage, frame);
    }
    assert!(stage.tracker.reading().numbers.damaged_part > 0.0);
    stage.tracker.rezero();
    let flags = show(&mut stage, 6);
    let reading = stage.tracker.reading();
    assert!(!flags.has(Flag::GelDamaged) && reading.valid.at(120, 110) == 1, "{flags}");
    let frames = [7, 9, 11].map(|frame| show(&mut stage, frame));
    assert!(frames[2].has(Flag::GelDamaged), "found again with the new reference: {frames:?}");
}

#[test]
fn a_frame_in_which_specks_are_found_allocates_nothing() {
    let mut stage = Stage::new(None);
    let frames: Vec<Frame> = (0..8)
        .map(|frame| {
            let image = stage.render(&Motion::Shift { by_px: [0.8 * f64::from(frame), 0.3] });
            let (sequence, capture_time_s) = (frame as u64, f64::from(frame) / RATE);
            Frame { sequence, capture_time_s, pixels: Pixels::Rgb8(with_specks(image)) }
        })
        .collect();
    let (first, rest) = frames.split_at(2);
    for frame in first {
        stage.tracker.track(frame).unwrap();
    }
    assert!(stage.tracker.reading().numbers.damaged_part <= 0.0, "nothing is found yet");
    let allocations = allocation_counter::measure(|| {
        for frame in rest {
            stage.tracker.track(frame).unwrap();
        }
    });
    assert!(stage.tracker.reading().numbers.damaged_part > 0.0, "the specks are found");
    assert_eq!(allocations.count_total, 0, "{allocations:?}");
}

//! Images that do not match the reference are flagged: lost focus, another pattern, a covered lens.

use fingervision_gel::{Light, Motion, Sheet, SheetRenderer};
use fingervision_image::{Frame, Image, Pixels};
use fingervision_touch::{Fields, Flag, Flags, Profile, Tracker};

const SIZE: (usize, usize) = (240, 180);

/// Standard deviation of the blur of a camera in focus, px.
const SHARP_PX: f64 = 0.7;

fn render(sheet: &Sheet, motion: &Motion, seed: u64) -> Image<[u8; 3]> {
    SheetRenderer::new(sheet).unwrap().render(motion, Light::EVEN, seed).unwrap()
}

/// The flags of consecutive images.
fn flags(images: impl IntoIterator<Item = Image<[u8; 3]>>) -> Vec<Flags> {
    let mut tracker = Tracker::new(&Profile::default(), SIZE, true, Fields::NONE).unwrap();
    let frames = (0..).zip(images);
    frames
        .map(|(sequence, image)| {
            let frame = Frame { sequence, capture_time_s: sequence as f64 / 90.0, pixels: Pixels::Rgb8(image) };
            tracker.track(&frame).unwrap().flags
        })
        .collect()
}

/// A press in eight frames; the last ones have this additional blur.
fn press(sheet: &Sheet, more_px: f64) -> Vec<Flags> {
    let bump = Motion::radial_bump(sheet.centre_px(), 5.0);
    let frames = (0..8_u32).map(|step| {
        let blur_px = if step < 4 { SHARP_PX } else { SHARP_PX.hypot(more_px) };
        render(&Sheet { blur_px, ..sheet.clone() }, &bump.at(f64::from(step) / 7.0), u64::from(step))
    });
    flags(frames)
}

#[test]
fn lost_focus_is_flagged_and_a_press_in_focus_is_not() {
    for cell_size_px in [2.5, 4.0, 8.0] {
        let sheet = Sheet { width: SIZE.0, height: SIZE.1, cell_size_px, noise_levels: 3.0, ..Sheet::default() };
        for (more_px, is_flagged) in [(0.0, false), (1.0, true), (1.5, true), (2.5, true)] {
            let flags = press(&sheet, more_px);
            assert!(flags[..4].iter().all(|flags| *flags == Flags::default()), "{cell_size_px} px: {flags:?}");
            for flags in &flags[4..] {
                let is_out = flags.has(Flag::OutOfFocus);
                assert_eq!(is_out, is_flagged, "cells of {cell_size_px} px, {more_px} px of blur: {flags}");
            }
        }
    }
}

#[test]
fn an_image_of_another_pattern_is_flagged() {
    let sheet = Sheet { width: SIZE.0, height: SIZE.1, ..Sheet::default() };
    let other = Sheet { pattern_seed: 7, ..sheet.clone() };
    let flags = flags([render(&sheet, &Motion::STILL, 1), render(&other, &Motion::STILL, 2)]);
    assert!(flags[1].has(Flag::Lost) && flags[1].has(Flag::ImageMismatch), "{flags:?}");
}

#[test]
fn a_covered_lens_is_lost() {
    let sheet = Sheet { width: SIZE.0, height: SIZE.1, ..Sheet::default() };
    let dark = Image::from_fn(SIZE.0, SIZE.1, |x, y| [((x * 7 + y * 13) % 5) as u8; 3]);
    let flags = flags([render(&sheet, &Motion::STILL, 1), dark]);
    assert!(flags[1].has(Flag::Lost) && !flags[0].has(Flag::Lost), "{flags:?}");
}

/// An image with a square of another pattern in the middle.
fn hide(image: &Image<[u8; 3]>, size_px: usize) -> Image<[u8; 3]> {
    let other = Sheet { pattern_seed: 7, width: SIZE.0, height: SIZE.1, ..Sheet::default() };
    let other = render(&other, &Motion::STILL, 9);
    let (left, top) = ((SIZE.0 - size_px) / 2, (SIZE.1 - size_px) / 2);
    Image::from_fn(SIZE.0, SIZE.1, |x, y| {
        let is_hidden = (left..left + size_px).contains(&x) && (top..top + size_px).contains(&y);
        if is_hidden { other.at(x, y) } else { image.at(x, y) }
    })
}

#[test]
fn a_hidden_area_is_flagged_at_once_and_until_it_is_seen_again() {
    let sheet = Sheet { width: SIZE.0, height: SIZE.1, ..Sheet::default() };
    let bump = Motion::radial_bump(sheet.centre_px(), 5.0);
    let frames: Vec<_> =
        (0..6_u32).map(|step| render(&sheet, &bump.at(f64::from(step) / 5.0), u64::from(step))).collect();
    let seen = |step: usize| frames[step].clone();
    let images =
        [seen(0), seen(1), hide(&frames[1], 64), hide(&frames[2], 64), hide(&frames[2], 64), seen(4), seen(4), seen(5)];
    let flags = flags(images);
    let is_lost: Vec<bool> = flags.iter().map(|flags| flags.has(Flag::AreaLost)).collect();
    assert_eq!(is_lost[..5], [false, false, true, true, true], "{flags:?}");
    assert_eq!(is_lost[6..], [false, false], "found again within two frames: {flags:?}");
}

#[test]
fn a_pattern_that_has_mostly_left_the_image_is_uncertain() {
    let sheet = Sheet { width: SIZE.0, height: SIZE.1, ..Sheet::default() };
    let step_px = 0.11 * SIZE.0 as f64;
    let images =
        [0_u32, 1, 2, 3, 4, 5, 6].map(|step| render(&sheet, &Motion::shift(f64::from(step) * step_px), step.into()));
    let flags = flags(images);
    let is_uncertain: Vec<bool> = flags.iter().map(|flags| flags.has(Flag::UncertainFlow)).collect();
    assert!(!is_uncertain[..4].contains(&true) && is_uncertain[5], "{flags:?}");
}

/// The sheet shifted to the right, px, while the shutter was open over the last `open_px` of its way.
fn slide(sheet: &Sheet, to_px: f64, open_px: f64) -> Image<[u8; 3]> {
    let images: Vec<_> = (0..8_u32)
        .map(|step| render(sheet, &Motion::shift(to_px - open_px * f64::from(step) / 7.0), u64::from(step)))
        .collect();
    Image::from_fn(SIZE.0, SIZE.1, |x, y| {
        let sum = |channel: usize| images.iter().map(|image| usize::from(image.at(x, y)[channel])).sum::<usize>();
        [0, 1, 2].map(|channel| ((sum(channel) + images.len() / 2) / images.len()) as u8)
    })
}

#[test]
fn images_blurred_by_their_motion_are_flagged_and_sharp_ones_of_the_same_motion_are_not() {
    let sheet = Sheet { width: SIZE.0, height: SIZE.1, ..Sheet::default() };
    for (open_px, is_flagged) in [(0.0, false), (5.0, true)] {
        let slides = [0.0, 8.0, 16.0, 24.0].map(|to_px| slide(&sheet, to_px, if to_px > 0.0 { open_px } else { 0.0 }));
        for flags in &flags(slides)[1..] {
            assert_eq!(flags.has(Flag::OutOfFocus), is_flagged, "{open_px} px of the way: {flags}");
        }
    }
}

//! Flow, deviation and validity if the picture is less sharp than the reference.

use fingervision_flow::{Estimate, FlowEstimator, FlowField, FlowHistory, FlowParams, Picture, Preset, Start};
use fingervision_gel::{Light, Motion, Sheet, SheetRenderer};
use fingervision_image::{Image, Pixels, Rect};

const SIZE: (usize, usize) = (240, 180);

/// An image blurred by a Gaussian with a standard deviation of `blur_px`.
fn render(motion: &Motion, blur_px: f64, seed: u64) -> Image<[u8; 3]> {
    let sheet = Sheet { width: SIZE.0, height: SIZE.1, blur_px, ..Sheet::default() };
    SheetRenderer::new(&sheet).unwrap().render(motion, Light::EVEN, seed).unwrap()
}

fn load(estimator: &FlowEstimator, image: Image<[u8; 3]>) -> Picture {
    let mut picture = estimator.picture();
    picture.load(&Pixels::Rgb8(image), Rect::whole(SIZE.0, SIZE.1)).unwrap();
    picture
}

/// The flow from a sharp picture at rest, starting from zero flow.
fn follow(preset: Preset, current: Image<[u8; 3]>) -> Estimate {
    let params = FlowParams { preset, ..FlowParams::default() };
    let mut estimator = FlowEstimator::new(SIZE.0, SIZE.1, &params).unwrap();
    let mut reference = estimator.reference();
    let rest = load(&estimator, render(&Motion::STILL, SHARP_PX, 1));
    estimator.prepare(&rest, &mut reference);
    let mut estimate = Estimate::new(SIZE.0, SIZE.1);
    let current = load(&estimator, current);
    estimator.estimate(&reference, &current, Start::Flow(&FlowField::zero(SIZE.0, SIZE.1)), &mut estimate);
    estimate
}

/// Standard deviation of the blur of a camera in focus, px.
const SHARP_PX: f64 = 0.7;

/// Mean error of the valid pixels 16 px and more from the border, px, and the part of them within two deviations.
fn judge(estimate: &Estimate, motion: &Motion, least_valid: f32) -> (f32, f32) {
    let truth = motion.flow(SIZE.0, SIZE.1);
    let (mut sum, mut covered, mut count) = (0.0, 0.0, 0.0);
    for y in 16..SIZE.1 - 16 {
        for x in (16..SIZE.0 - 16).filter(|&x| estimate.valid.at(x, y) == 1) {
            let (u, v) = (estimate.flow.u.at(x, y), estimate.flow.v.at(x, y));
            let error = (u - truth.u.at(x, y)).hypot(v - truth.v.at(x, y));
            sum += error;
            covered += f32::from(u8::from(error <= 2.0 * estimate.deviation.at(x, y)));
            count += 1.0;
        }
    }
    assert!(count > least_valid, "only {count} pixels are valid");
    (sum / count, covered / count)
}

#[test]
fn errors_on_a_blurred_picture_agree_with_its_deviation() {
    for motion in [Motion::shift(0.8), Motion::radial_bump([119.5, 89.5], 1.5)] {
        let estimate = follow(Preset::Affine, render(&motion, SHARP_PX.hypot(1.0), 2));
        let (error, covered) = judge(&estimate, &motion, 23_000.0);
        assert!(error < 0.08, "{motion:?}: off by {error} px");
        assert!(covered > 0.95, "{motion:?}: {covered} within two deviations");
        assert!(estimate.unexplained > 0.015, "{motion:?}: {} unexplained", estimate.unexplained);
    }
}

/// The mean of images of a motion that gets faster while the shutter is open, up to `last_px`, and its mean shift, px.
fn accelerated(last_px: f64) -> (Image<[u8; 3]>, f64) {
    let shifts: Vec<f64> = (0..=8).map(|step| last_px * (f64::from(step) / 8.0).powi(2)).collect();
    let images: Vec<_> = shifts.iter().zip(2..).map(|(&dx, seed)| render(&Motion::shift(dx), SHARP_PX, seed)).collect();
    let count = images.len();
    let mean = Image::from_fn(SIZE.0, SIZE.1, |x, y| {
        let sum = |channel: usize| images.iter().map(|image| usize::from(image.at(x, y)[channel])).sum::<usize>();
        [0, 1, 2].map(|channel| ((sum(channel) + count / 2) / count) as u8)
    });
    (mean, shifts.iter().sum::<f64>() / count as f64)
}

/// Part of the pixels 16 px and more from the border that are valid, and that are valid with an error above 0.5 px.
fn valid_and_wrong(estimate: &Estimate, motion: &Motion) -> (f32, f32) {
    let truth = motion.flow(SIZE.0, SIZE.1);
    let (mut valid, mut wrong, mut count) = (0.0, 0.0, 0.0);
    for y in 16..SIZE.1 - 16 {
        for x in 16..SIZE.0 - 16 {
            let (u, v) = (estimate.flow.u.at(x, y), estimate.flow.v.at(x, y));
            let error = (u - truth.u.at(x, y)).hypot(v - truth.v.at(x, y));
            let is_valid = estimate.valid.at(x, y) == 1;
            count += 1.0;
            valid += f32::from(u8::from(is_valid));
            wrong += f32::from(u8::from(is_valid && error > 0.5));
        }
    }
    (valid / count, wrong / count)
}

#[test]
fn pixels_that_motion_blurs_too_much_are_not_valid() {
    // An accelerated motion of 6 px puts the blurred image more than 0.5 px from its mean position.
    for (last_px, least_valid, most_wrong) in [(2.0, 0.99, 0.0), (4.0, 0.9, 0.0), (6.0, 0.0, 0.05), (9.0, 0.0, 0.001)] {
        let (image, mean_px) = accelerated(last_px);
        let (valid, wrong) = valid_and_wrong(&follow(Preset::Affine, image), &Motion::shift(mean_px));
        assert!(valid >= least_valid, "{last_px} px: {valid} valid");
        assert!(wrong <= most_wrong, "{last_px} px: {wrong} valid and wrong");
    }
}

#[test]
fn blur_lowers_sharpness_for_every_cell_size() {
    for cell_px in [3.0, 6.0, 12.0] {
        let sharpness = |blur_px: f64| {
            let sheet = Sheet { width: SIZE.0, height: SIZE.1, blur_px, cell_size_px: cell_px, ..Sheet::default() };
            let image = SheetRenderer::new(&sheet).unwrap().render(&Motion::STILL, Light::EVEN, 1).unwrap();
            load(&FlowEstimator::new(SIZE.0, SIZE.1, &FlowParams::default()).unwrap(), image).sharpness()
        };
        let sharp = sharpness(SHARP_PX);
        for (more_px, part) in [(1.0, 0.8), (2.0, 0.7)] {
            let blurred = sharpness(SHARP_PX.hypot(more_px));
            assert!(blurred < part * sharp, "cells of {cell_px} px, {more_px} px of blur: {blurred} of {sharp}");
        }
    }
}

#[test]
fn a_covered_lens_matches_nothing() {
    let estimate = follow(Preset::Affine, Image::filled(SIZE.0, SIZE.1, [90; 3]));
    assert!(estimate.matched < 0.01, "{} of the patches match", estimate.matched);
    assert!(estimate.valid.values().iter().all(|&valid| valid == 0));
}

#[test]
fn the_deviation_of_the_search_alone_covers_its_error() {
    for preset in [Preset::Ultrafast, Preset::Fast, Preset::Medium] {
        for motion in [Motion::shift(0.6), Motion::radial_bump([119.5, 89.5], 3.0)] {
            let estimate = follow(preset, render(&motion, SHARP_PX, 2));
            let (error, covered) = judge(&estimate, &motion, 3_000.0);
            assert!(covered > 0.85, "{preset:?}, {motion:?}: {covered} within two deviations, off by {error} px");
        }
    }
}

/// Mean error of all pixels at a distance from the border, px.
fn error_inside(estimate: &Estimate, motion: &Motion, border: usize) -> f32 {
    let truth = motion.flow(SIZE.0, SIZE.1);
    let (mut sum, mut count) = (0.0, 0.0);
    for y in border..SIZE.1 - border {
        for x in border..SIZE.0 - border {
            let (u, v) = (estimate.flow.u.at(x, y), estimate.flow.v.at(x, y));
            sum += (u - truth.u.at(x, y)).hypot(v - truth.v.at(x, y));
            count += 1.0;
        }
    }
    sum / count
}

/// The mean of images of a steady shift to the right, from `from_px` to `to_px`.
fn exposed(from_px: f64, to_px: f64) -> Image<[u8; 3]> {
    let shifts = (0..=16).map(|step| from_px + (to_px - from_px) * f64::from(step) / 16.0);
    let images: Vec<_> = shifts.zip(2..).map(|(dx, seed)| render(&Motion::shift(dx), SHARP_PX, seed)).collect();
    Image::from_fn(SIZE.0, SIZE.1, |x, y| {
        let mean = |channel: usize| images.iter().map(|image| usize::from(image.at(x, y)[channel])).sum::<usize>() / 17;
        [0, 1, 2].map(|channel| mean(channel) as u8)
    })
}

#[test]
fn a_steady_motion_is_followed_while_the_shutter_is_open() {
    for colour in [true, false] {
        for (speed_px, exposure, most_px) in [(4.0, 0.3, 0.03), (6.0, 0.7, 0.03), (10.0, 0.4, 0.1)] {
            let params = FlowParams { colour, ..FlowParams::default() };
            let mut estimator = FlowEstimator::new(SIZE.0, SIZE.1, &params).unwrap();
            let mut reference = estimator.reference();
            estimator.prepare(&load(&estimator, render(&Motion::STILL, SHARP_PX, 1)), &mut reference);
            let mut history = FlowHistory::at_rest(SIZE.0, SIZE.1);
            let mut estimate = Estimate::new(SIZE.0, SIZE.1);
            for frame in 1..=3 {
                let middle_px = speed_px * f64::from(frame);
                let path_px = exposure * speed_px;
                let image = exposed(middle_px - 0.5 * path_px, middle_px + 0.5 * path_px);
                let current = load(&estimator, image);
                let start = Start::History(&history);
                let measured = allocation_counter::measure(|| {
                    estimator.estimate(&reference, &current, start, &mut estimate);
                });
                assert_eq!(measured.count_total, 0, "frame {frame}");
                history.push(&estimate.flow);
            }
            let what = format!("colour {colour}, {speed_px} px a frame, exposure {exposure}");
            let motion = Motion::shift(3.0 * speed_px);
            let error = error_inside(&estimate, &motion, 48);
            assert!(error < most_px, "{what}: off by {error} px");
            let (_, wrong) = valid_and_wrong(&estimate, &motion);
            assert!(wrong < 0.001, "{what}: {wrong} valid and wrong");
        }
    }
}

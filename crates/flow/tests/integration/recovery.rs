//! Areas that move too far for a warm start are found by a search.

use fingervision_flow::{Estimate, FlowEstimator, FlowField, FlowParams, Start};
use fingervision_gel::{Light, Motion, Sheet, SheetRenderer};
use fingervision_image::{Image, Pixels, Rect};

const SIZE: (usize, usize) = (320, 240);

/// The area that moves, before it moves.
const AREA: Rect = Rect { x: 100, y: 72, width: 112, height: 96 };

/// Distance from the area's edge, px, up to which a patch or its neighbours contain both motions.
const EDGE: usize = 28;

fn render(motion: &Motion, pattern_seed: u64, seed: u64) -> Image<[u8; 3]> {
    let sheet = Sheet { width: SIZE.0, height: SIZE.1, pattern_seed, ..Sheet::default() };
    SheetRenderer::new(&sheet).unwrap().render(motion, Light::EVEN, seed).unwrap()
}

/// The sheet at rest; [`AREA`] of `other` is drawn into it, displaced to the right by whole pixels.
fn displaced(other: &Image<[u8; 3]>, right: usize) -> Image<[u8; 3]> {
    let mut image = render(&Motion::STILL, 1, 2);
    for y in AREA.y..AREA.y + AREA.height {
        let moved = &other.row(y)[AREA.x..][..AREA.width];
        image.row_mut(y)[AREA.x + right..][..AREA.width].copy_from_slice(moved);
    }
    image
}

/// Tracks images; the first starts from zero flow, every other one from the flow of the previous image.
fn follow(images: &[Image<[u8; 3]>]) -> Estimate {
    let mut estimator = FlowEstimator::new(SIZE.0, SIZE.1, &FlowParams::default()).unwrap();
    let (mut picture, mut reference) = (estimator.picture(), estimator.reference());
    picture.load(&Pixels::Rgb8(render(&Motion::STILL, 1, 1)), Rect::whole(SIZE.0, SIZE.1)).unwrap();
    estimator.prepare(&picture, &mut reference);
    let mut before = FlowField::zero(SIZE.0, SIZE.1);
    let mut estimate = Estimate::new(SIZE.0, SIZE.1);
    for image in images {
        picture.load(&Pixels::Rgb8(image.clone()), Rect::whole(SIZE.0, SIZE.1)).unwrap();
        estimator.estimate(&reference, &picture, Start::Flow(&before), &mut estimate);
        before.copy_from(&estimate.flow);
    }
    estimate
}

/// Mean error against a displacement to the right, px, and part of the pixels that are valid, in an area.
fn judge(estimate: &Estimate, right: f32, area: Rect) -> (f32, f32) {
    let (mut error, mut valid) = (0.0, 0.0);
    for y in area.y..area.y + area.height {
        for x in area.x..area.x + area.width {
            error += (estimate.flow.u.at(x, y) - right).hypot(estimate.flow.v.at(x, y));
            valid += f32::from(estimate.valid.at(x, y));
        }
    }
    let count = (area.width * area.height) as f32;
    (error / count, valid / count)
}

/// A rectangle without its margin.
fn inside(area: Rect, margin: usize) -> Rect {
    let Rect { x, y, width, height } = area;
    Rect { x: x + margin, y: y + margin, width: width - 2 * margin, height: height - 2 * margin }
}

#[test]
fn an_area_that_jumps_is_found_in_the_same_frame() {
    for right in [3, 7, 12, 20] {
        let estimate = follow(&[displaced(&render(&Motion::STILL, 1, 3), right)]);
        let (error, valid) = judge(&estimate, right as f32, inside(AREA, EDGE));
        assert!(error < 0.05 && valid > 0.9, "by {right} px: off by {error} px, {valid} valid");
        let beside = Rect { x: 16, y: 16, width: 68, height: 208 };
        let (error, valid) = judge(&estimate, 0.0, beside);
        assert!(error < 0.02 && valid > 0.99, "beside it, by {right} px: off by {error} px, {valid} valid");
    }
}

#[test]
fn an_area_that_was_hidden_is_found_within_two_frames() {
    let hidden = displaced(&render(&Motion::STILL, 77, 3), 0);
    let seen = displaced(&render(&Motion::STILL, 1, 3), 15);
    for frames_hidden in [1, 2, 5, 6] {
        let mut images = vec![hidden.clone(); frames_hidden];
        let (_, valid) = judge(&follow(&images), 0.0, inside(AREA, EDGE));
        assert!(valid < 0.05, "{valid} of the hidden area is valid");
        images.extend([seen.clone(), seen.clone()]);
        let (error, valid) = judge(&follow(&images), 15.0, inside(AREA, EDGE));
        assert!(error < 0.05 && valid > 0.9, "hidden for {frames_hidden}: off by {error} px, {valid} valid");
    }
}

#[test]
fn the_area_is_found_up_to_its_border() {
    // Above and below, the area borders on what is still along a straight line, and nothing is hidden.
    let top = Rect { height: 8, ..inside(AREA, EDGE) };
    for right in [12, 20] {
        let estimate = follow(&[displaced(&render(&Motion::STILL, 1, 3), right)]);
        for (y, displacement) in [(AREA.y, right as f32), (AREA.y - 8, 0.0)] {
            let (error, _) = judge(&estimate, displacement, Rect { y, ..top });
            assert!(error < 1.5, "by {right} px, from row {y}: off by {error} px");
        }
    }
}

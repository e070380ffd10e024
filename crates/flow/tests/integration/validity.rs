//! Validity and deviation of an estimate, on rendered patterns with exact truth.

use fingervision_flow::{Estimate, FlowEstimator, FlowField, FlowParams, Start, ValidityParams};
use fingervision_gel::{Light, Motion, Sheet, SheetRenderer};
use fingervision_image::{Image, Pixels, Rect};

const SIZE: (usize, usize) = (240, 180);

fn sheet() -> Sheet {
    Sheet { width: SIZE.0, height: SIZE.1, ..Sheet::default() }
}

fn render(motion: &Motion, seed: u64) -> Image<[u8; 3]> {
    SheetRenderer::new(&sheet()).unwrap().render(motion, Light::EVEN, seed).unwrap()
}

fn estimate(params: &FlowParams, rest: Image<[u8; 3]>, current: Image<[u8; 3]>) -> Estimate {
    let mut estimator = FlowEstimator::new(SIZE.0, SIZE.1, params).unwrap();
    let (mut first, mut second) = (estimator.picture(), estimator.picture());
    first.load(&Pixels::Rgb8(rest), Rect::whole(SIZE.0, SIZE.1)).unwrap();
    second.load(&Pixels::Rgb8(current), Rect::whole(SIZE.0, SIZE.1)).unwrap();
    let mut reference = estimator.reference();
    estimator.prepare(&first, &mut reference);
    let mut estimate = Estimate::new(SIZE.0, SIZE.1);
    estimator.estimate(&reference, &second, Start::Search(None), &mut estimate);
    estimate
}

/// Part of a rectangle's pixels that are valid.
fn valid_part(estimate: &Estimate, area: Rect) -> f64 {
    let rows = estimate.valid.rows().skip(area.y).take(area.height);
    let sum: f64 = rows.flat_map(|row| &row[area.x..][..area.width]).map(|&valid| f64::from(valid)).sum();
    sum / (area.width * area.height) as f64
}

/// Covers a part of an image with another pattern.
fn cover(image: &mut Image<[u8; 3]>, area: Rect) {
    let other = Sheet { pattern_seed: 99, ..sheet() };
    let other = SheetRenderer::new(&other).unwrap().render(&Motion::STILL, Light::EVEN, 3).unwrap();
    for y in area.y..area.y + area.height {
        image.row_mut(y)[area.x..][..area.width].copy_from_slice(&other.row(y)[area.x..][..area.width]);
    }
}

#[test]
fn occluded_patches_are_not_valid_and_do_not_affect_their_neighbours() {
    let motion = Motion::shift(2.0);
    let mut current = render(&motion, 2);
    let covered = Rect { x: 80, y: 60, width: 64, height: 48 };
    cover(&mut current, covered);
    let estimate = estimate(&FlowParams::default(), render(&Motion::STILL, 1), current);
    let inner = Rect { x: 92, y: 72, width: 40, height: 24 };
    assert!(valid_part(&estimate, inner) < 0.05, "{} of the covered part is valid", valid_part(&estimate, inner));
    let beside = Rect { x: 16, y: 16, width: 48, height: 140 };
    assert!(valid_part(&estimate, beside) > 0.99, "{} beside it is valid", valid_part(&estimate, beside));
    let truth = motion.flow(SIZE.0, SIZE.1);
    for (x, y) in [(60, 84), (164, 84), (112, 40), (112, 130)] {
        let error = (estimate.flow.u.at(x, y) - truth.u.at(x, y)).hypot(estimate.flow.v.at(x, y) - truth.v.at(x, y));
        assert!(error < 0.03, "({x}, {y}) beside the covered part is off by {error} px");
    }
}

#[test]
fn the_predicted_deviation_bounds_the_error() {
    let motion = Motion::radial_bump(sheet().centre_px(), 5.0);
    let estimate = estimate(&FlowParams::default(), render(&Motion::STILL, 1), render(&motion, 2));
    let truth = motion.flow(SIZE.0, SIZE.1);
    let (mut sum, mut count) = (0.0, 0);
    for y in 16..SIZE.1 - 16 {
        for x in 16..SIZE.0 - 16 {
            let error =
                (estimate.flow.u.at(x, y) - truth.u.at(x, y)).hypot(estimate.flow.v.at(x, y) - truth.v.at(x, y));
            sum += f64::from(error / estimate.deviation.at(x, y)).powi(2);
            count += 1;
        }
    }
    let ratio = (sum / f64::from(count)).sqrt();
    assert!((0.2..2.0).contains(&ratio), "error over predicted deviation is {ratio} in the root mean square");
}

#[test]
fn a_uniform_image_is_nowhere_valid() {
    let grey = Image::filled(SIZE.0, SIZE.1, [120u8; 3]);
    let estimate = estimate(&FlowParams::default(), grey.clone(), grey);
    assert!(estimate.valid.values().iter().all(|&valid| valid == 0));
    assert!(estimate.flow.u.values().iter().all(|u| u.is_finite()));
    assert_eq!(estimate.matched.to_bits(), 0.0_f32.to_bits());
}

#[test]
fn another_pattern_does_not_match() {
    let mut other = render(&Motion::STILL, 1);
    cover(&mut other, Rect::whole(SIZE.0, SIZE.1));
    let estimate = estimate(&FlowParams::default(), render(&Motion::STILL, 1), other);
    assert!(estimate.matched < 0.25, "{} of the patches match", estimate.matched);
}

#[test]
fn the_round_trip_check_rejects_only_occluded_pixels() {
    let params = FlowParams {
        validity: ValidityParams { max_round_trip_px: Some(0.1), ..ValidityParams::default() },
        ..FlowParams::default()
    };
    let motion = Motion::radial_bump(sheet().centre_px(), 6.0);
    let mut current = render(&motion, 2);
    cover(&mut current, Rect { x: 150, y: 20, width: 64, height: 48 });
    let estimate = estimate(&params, render(&Motion::STILL, 1), current);
    let still = Rect { x: 24, y: 100, width: 100, height: 56 };
    assert!(valid_part(&estimate, still) > 0.99, "{} of the part at rest is valid", valid_part(&estimate, still));
    let covered = Rect { x: 162, y: 32, width: 40, height: 24 };
    assert!(valid_part(&estimate, covered) < 0.05, "{} of the covered part is valid", valid_part(&estimate, covered));
}

#[test]
fn warm_and_cold_start_give_the_same_flow() {
    let params = FlowParams::default();
    let motion = Motion::radial_bump(sheet().centre_px(), 8.0);
    let mut estimator = FlowEstimator::new(SIZE.0, SIZE.1, &params).unwrap();
    let (mut first, mut second) = (estimator.picture(), estimator.picture());
    first.load(&Pixels::Rgb8(render(&Motion::STILL, 1)), Rect::whole(SIZE.0, SIZE.1)).unwrap();
    second.load(&Pixels::Rgb8(render(&motion, 2)), Rect::whole(SIZE.0, SIZE.1)).unwrap();
    let mut reference = estimator.reference();
    estimator.prepare(&first, &mut reference);
    let mut cold = Estimate::new(SIZE.0, SIZE.1);
    estimator.estimate(&reference, &second, Start::Search(None), &mut cold);
    let mut start = FlowField::zero(SIZE.0, SIZE.1);
    start.copy_from(&motion_before(&motion));
    let mut warm = Estimate::new(SIZE.0, SIZE.1);
    estimator.estimate(&reference, &second, Start::Flow(&start), &mut warm);
    let (mut sum, mut count) = (0.0, 0);
    for y in 16..SIZE.1 - 16 {
        for x in 16..SIZE.0 - 16 {
            if cold.valid.at(x, y) & warm.valid.at(x, y) == 1 {
                sum += (cold.flow.u.at(x, y) - warm.flow.u.at(x, y)).abs();
                count += 1;
            }
        }
    }
    let mean = sum / count as f32;
    assert!(count > 24_000 && mean < 0.02, "over {count} pixels the two differ by {mean} px");
}

/// The flow a frame earlier, when the press was nine tenths as deep.
fn motion_before(motion: &Motion) -> FlowField {
    let truth = motion.at(0.9).flow(SIZE.0, SIZE.1);
    FlowField { u: truth.u, v: truth.v }
}

/// Mean error near the border of a scaled square, px, and the part of the pixels there that are valid.
fn at_border(motion: &Motion, estimate: &Estimate, half_side: f64) -> (f64, f64) {
    let truth = motion.flow(SIZE.0, SIZE.1);
    let [cx, cy] = sheet().centre_px();
    let (mut sum, mut valid, mut count) = (0.0, 0.0, 0.0);
    for y in 8..SIZE.1 - 8 {
        for x in 8..SIZE.0 - 8 {
            if ((x as f64 - cx).abs().max((y as f64 - cy).abs()) - half_side).abs() > 6.0 {
                continue;
            }
            let (u, v) = (estimate.flow.u.at(x, y) - truth.u.at(x, y), estimate.flow.v.at(x, y) - truth.v.at(x, y));
            sum += f64::from(u.hypot(v));
            valid += f64::from(estimate.valid.at(x, y));
            count += 1.0;
        }
    }
    (sum / count, valid / count)
}

#[test]
fn finer_patches_resolve_a_sharp_border() {
    let half_side = 45.0;
    let motion =
        Motion::ScaledSquare { centre_px: sheet().centre_px(), half_side_px: half_side, decay_px: 8.0, scale: 1.12 };
    let flow = |fine_steps: usize| {
        let mut params = FlowParams::default();
        params.affine.fine_steps = fine_steps;
        at_border(&motion, &estimate(&params, render(&Motion::STILL, 1), render(&motion, 2)), half_side)
    };
    let ((coarse_px, coarse_valid), (fine_px, fine_valid)) = (flow(0), flow(2));
    assert!(fine_px < 0.9 * coarse_px, "{fine_px} px with finer patches, {coarse_px} px without");
    assert!(fine_valid > 0.75 && coarse_valid < 0.25, "{fine_valid} valid with finer patches, {coarse_valid} without");
}

#[test]
fn many_fine_steps_do_not_diverge() {
    let motion = Motion::radial_bump(sheet().centre_px(), 8.0);
    let mut current = render(&motion, 2);
    cover(&mut current, Rect { x: 80, y: 60, width: 40, height: 40 });
    let mut params = FlowParams::default();
    params.affine.fine_steps = 40;
    let estimate = estimate(&params, render(&Motion::STILL, 1), current);
    let truth = motion.flow(SIZE.0, SIZE.1);
    let farthest = (0..SIZE.0 * SIZE.1)
        .map(|k| (k % SIZE.0, k / SIZE.0))
        .fold(0.0_f32, |most, (x, y)| most.max((estimate.flow.u.at(x, y) - truth.u.at(x, y)).abs()));
    assert!(farthest < 15.0, "a hidden pixel is off by {farthest} px");
}

/// Replaces an image from a column on by a grey area with nothing but noise, as if the pattern ended there.
fn end_pattern(image: &mut Image<[u8; 3]>, column: usize, seed: u64) {
    let (first, second) = (render(&Motion::STILL, seed), render(&Motion::STILL, seed + 1));
    for y in 0..SIZE.1 {
        for x in column..SIZE.0 {
            let noise = |channel: usize| first.at(x, y)[channel].saturating_sub(second.at(x, y)[channel]);
            image.row_mut(y)[x] = std::array::from_fn(|channel| 120 + noise(channel));
        }
    }
}

#[test]
fn valid_flow_where_the_pattern_ends_is_right() {
    for (end, shift) in [(130, 8), (132, 8), (134, -6), (136, 8), (138, 11)] {
        let motion = Motion::Shift { by_px: [f64::from(shift), 3.0] };
        let (mut rest, mut current) = (render(&Motion::STILL, 1), render(&motion, 2));
        end_pattern(&mut rest, end, 3);
        end_pattern(&mut current, end.saturating_add_signed(shift as isize), 5);
        let estimate = estimate(&FlowParams::default(), rest, current);
        let flow = motion.flow(SIZE.0, SIZE.1);
        let is_wrong = |x: usize, y: usize| {
            let (u, v) = (estimate.flow.u.at(x, y) - flow.u.at(x, y), estimate.flow.v.at(x, y) - flow.v.at(x, y));
            estimate.valid.at(x, y) == 1 && u.hypot(v) > 0.5
        };
        let wrong = (0..SIZE.0 * SIZE.1).filter(|k| is_wrong(k % SIZE.0, k / SIZE.0)).count();
        // Of more than 20,000 valid ones.
        assert!(wrong < 40, "{wrong} valid pixels are wrong, end {end}, shift {shift} px");
        let inside = Rect { x: 16, y: 16, width: end - 32, height: SIZE.1 - 32 };
        assert!(valid_part(&estimate, inside) > 0.99, "{} valid, end {end}", valid_part(&estimate, inside));
    }
}

//! Specks in front of a synthetic gel.

use super::*;

const SIZE: (usize, usize) = (160, 128);
const SPECK: [f32; 2] = [80.0, 64.0];

/// Random levels 4 px apart, linear in between.
fn texture(x: f32, y: f32) -> f32 {
    let level = |column: i32, row: i32| {
        let mixed = (column.wrapping_mul(73_856_093) ^ row.wrapping_mul(19_349_663)).wrapping_mul(83_492_791);
        (mixed >> 8 & 0xff) as f32
    };
    let (x, y) = (x / 4.0 + 100.0, y / 4.0 + 100.0);
    let (column, row) = (x as i32, y as i32);
    let across = |row: i32| {
        let (left, right) = (level(column, row), level(column + 1, row));
        left + (x - column as f32) * (right - left)
    };
    across(row) + (y - row as f32) * (across(row + 1) - across(row))
}

fn is_speck(x: usize, y: usize, radius_px: f32) -> bool {
    length2(difference([x as f32, y as f32], SPECK)) < radius_px * radius_px
}

/// The image of a gel that has moved by `motion`, behind an opaque speck.
fn image(motion: [f32; 2], radius_px: f32) -> Image<f32> {
    Image::from_fn(SIZE.0, SIZE.1, |x, y| {
        if is_speck(x, y, radius_px) { 20.0 } else { texture(x as f32 - motion[0], y as f32 - motion[1]) }
    })
}

/// The estimate of a flow.
fn estimate(flow: impl Fn(usize, usize) -> [f32; 2]) -> Estimate {
    let mut estimate = Estimate::new(SIZE.0, SIZE.1);
    for y in 0..SIZE.1 {
        for x in 0..SIZE.0 {
            [estimate.flow.u.row_mut(y)[x], estimate.flow.v.row_mut(y)[x]] = flow(x, y);
        }
        estimate.valid.row_mut(y).fill(1);
        estimate.deviation.row_mut(y).fill(0.01);
    }
    estimate
}

/// Watches a gel that moves behind a speck, whose flow is zero.
fn watch(radius_px: f32, path: &[[f32; 2]]) -> (Dirt, Estimate) {
    let mut dirt = Dirt::new(SIZE, 2.0);
    dirt.take_reference(&image([0.0; 2], radius_px));
    let mut last = estimate(|_, _| [0.0; 2]);
    for &motion in path {
        last = estimate(|x, y| if is_speck(x, y, radius_px + 3.0) { [0.0; 2] } else { motion });
        dirt.watch(&image(motion, radius_px), &last);
    }
    (dirt, last)
}

#[test]
fn a_speck_in_front_of_moving_gel_is_hidden_and_the_flow_behind_it_interpolated() {
    let motion = [4.0, 1.5];
    let (dirt, mut seen) = watch(5.0, &[[1.5, 0.5], [2.5, 1.0], motion]);
    assert!((0.02..0.1).contains(&dirt.part()), "{}", dirt.part());
    dirt.hide(&mut seen);
    for y in 0..SIZE.1 {
        for x in 0..SIZE.0 {
            let flow = [seen.flow.u.at(x, y), seen.flow.v.at(x, y)];
            assert!(length2(difference(flow, motion)) < 1e-6, "({x}, {y}) moves by {flow:?}");
            let is_far = !is_speck(x, y, 30.0);
            assert!(is_far || !is_speck(x, y, 8.0) || seen.valid.at(x, y) == 0, "({x}, {y}) is valid");
            assert!(!is_far || seen.valid.at(x, y) == 1, "({x}, {y}) is not valid");
        }
    }
}

#[test]
fn nothing_is_dirty_where_the_gel_is_at_rest_or_moves_everywhere() {
    assert!(watch(5.0, &[[0.0; 2], [0.4, 0.3], [0.0; 2]]).0.part() <= 0.0, "at rest");
    let mut dirt = Dirt::new(SIZE, 2.0);
    dirt.take_reference(&image([0.0; 2], 0.0));
    for motion in [[1.5, 0.5], [2.5, 1.0], [4.0, 1.5]] {
        dirt.watch(&image(motion, 0.0), &estimate(|_, _| motion));
    }
    assert!(dirt.part() <= 0.0, "moving everywhere");
}

#[test]
fn gel_that_moves_away_from_a_point_is_not_dirty_there() {
    let radial = |x: usize, y: usize| [0.15 * (x as f32 - SPECK[0]), 0.15 * (y as f32 - SPECK[1])];
    let mut dirt = Dirt::new(SIZE, 2.0);
    dirt.take_reference(&image([0.0; 2], 0.0));
    let stretched = Image::from_fn(SIZE.0, SIZE.1, |x, y| {
        texture(SPECK[0] + (x as f32 - SPECK[0]) / 1.15, SPECK[1] + (y as f32 - SPECK[1]) / 1.15)
    });
    dirt.watch(&stretched, &estimate(radial));
    assert!(dirt.part() <= 0.0, "{}", dirt.part());
}

#[test]
fn a_new_reference_begins_without_dirt() {
    let (mut dirt, _) = watch(5.0, &[[1.5, 0.5], [2.5, 1.0]]);
    assert!(dirt.part() > 0.0);
    dirt.take_reference(&image([0.0; 2], 5.0));
    assert!(dirt.part() <= 0.0);
    let mut still = estimate(|_, _| [0.0; 2]);
    dirt.hide(&mut still);
    assert!(still.valid.values().iter().all(|&valid| valid == 1));
}

/// The flow of a gel that moves by `motion`, except in a disc that seems to rest.
fn with_still_disc(motion: [f32; 2], is_valid: bool) -> Estimate {
    let mut seen = estimate(|x, y| if is_speck(x, y, 8.0) { [0.0; 2] } else { motion });
    for y in 0..SIZE.1 {
        for x in 0..SIZE.0 {
            seen.valid.row_mut(y)[x] &= u8::from(is_valid || !is_speck(x, y, 8.0));
        }
    }
    seen
}

#[test]
fn gel_that_moves_is_not_dirty_even_if_its_flow_is_zero() {
    let mut dirt = Dirt::new(SIZE, 2.0);
    dirt.take_reference(&image([0.0; 2], 0.0));
    for motion in [[1.5, 0.5], [2.5, 1.0], [4.0, 1.5]] {
        dirt.watch(&image(motion, 0.0), &with_still_disc(motion, true));
    }
    assert!(dirt.part() <= 0.0, "{}", dirt.part());
}

#[test]
fn without_valid_flow_one_comparison_is_not_enough() {
    let motions = [[1.5, 0.5], [2.5, 1.0]];
    for (is_valid, frames) in [(true, 1), (false, 1), (false, 2)] {
        let mut dirt = Dirt::new(SIZE, 2.0);
        dirt.take_reference(&image([0.0; 2], 5.0));
        for &motion in &motions[..frames] {
            dirt.watch(&image(motion, 5.0), &with_still_disc(motion, is_valid));
        }
        assert_eq!(dirt.part() > 0.0, is_valid || frames == 2, "valid: {is_valid}, {frames} comparisons");
    }
}

#[test]
fn images_of_any_size_are_watched() {
    for size in [(32, 32), (45, 37), (9, 100)] {
        let mut dirt = Dirt::new(size, 2.0);
        let grey = Image::filled(size.0, size.1, 100.0);
        dirt.take_reference(&grey);
        let mut seen = Estimate::new(size.0, size.1);
        seen.flow.u.values_mut().fill(2.0);
        seen.valid.values_mut().fill(1);
        dirt.watch(&grey, &seen);
        dirt.hide(&mut seen);
        assert!(dirt.part() <= 0.0);
    }
}

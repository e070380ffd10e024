//! The guided filter against its definition, on edges, constants and holes.

use super::*;

const SIZE: (usize, usize) = (61, 45);

/// The definition, window by window in `f64`: He 2010 on cells, which for cells of one pixel is He 2010 itself.
fn by_definition(image: &Image<f32>, valid: &Image<u8>, params: &GuidedFilterParams) -> Vec<f64> {
    let (width, height) = image.size();
    let (cell, side) = (params.subsample, params.subsample as f64);
    let (columns, rows) = (width.div_ceil(cell), height.div_ceil(cell));
    let radius = (params.radius_px as f64 / side).round() as usize;
    let window = |column: usize, row: usize| {
        let rows = row.saturating_sub(radius)..rows.min(row + radius + 1);
        rows.flat_map(move |row| {
            (column.saturating_sub(radius)..columns.min(column + radius + 1)).map(move |column| (column, row))
        })
    };
    let pixels = |(column, row): (usize, usize)| {
        let rows = row * cell..height.min((row + 1) * cell);
        let inside = rows.flat_map(move |y| (column * cell..width.min((column + 1) * cell)).map(move |x| (x, y)));
        inside.filter(|&(x, y)| valid.at(x, y) == 1).map(|(x, y)| f64::from(image.at(x, y))).collect::<Vec<_>>()
    };
    let line = |column: usize, row: usize| {
        let cells = window(column, row).map(pixels).filter(|pixels| !pixels.is_empty());
        let means = cells.map(|pixels| (pixels.len() as f64, pixels.iter().sum::<f64>() / pixels.len() as f64));
        let means: Vec<(f64, f64)> = means.collect();
        let n: f64 = means.iter().map(|(n, _)| n).sum();
        let mean = means.iter().map(|(n, mean)| n * mean).sum::<f64>() / n;
        let variance = means.iter().map(|(n, m)| n * (m - mean).powi(2)).sum::<f64>() / n;
        let slope = variance / (variance + params.epsilon);
        (n > 0.0).then_some((slope, (1.0 - slope) * mean))
    };
    let lines: Vec<_> = (0..columns * rows).map(|i| line(i % columns, i / columns)).collect();
    let mean_line = |column: usize, row: usize| {
        let lines: Vec<_> = window(column, row).filter_map(|(column, row)| lines[row * columns + column]).collect();
        let sum = lines.iter().fold((0.0, 0.0), |sum, line| (sum.0 + line.0, sum.1 + line.1));
        let n = lines.len().max(1) as f64;
        (sum.0 / n, sum.1 / n)
    };
    let at = |x: usize, y: usize| {
        let place = |x: usize, cells: usize| ((x as f64 - (side - 1.0) / 2.0) / side).clamp(0.0, (cells - 1) as f64);
        let (column, row) = (place(x, columns), place(y, rows));
        let (mut slope, mut offset) = (0.0, 0.0);
        for (c, r) in [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| (column as usize + i, row as usize + j)) {
            let weight = (1.0 - (column - c as f64).abs()) * (1.0 - (row - r as f64).abs());
            if weight > 0.0 {
                let line = mean_line(c, r);
                (slope, offset) = (slope + weight * line.0, offset + weight * line.1);
            }
        }
        if valid.at(x, y) == 1 { slope * f64::from(image.at(x, y)) + offset } else { 0.0 }
    };
    (0..width * height).map(|i| at(i % width, i / width)).collect()
}

/// A step of `height` at column 30 under seeded noise of `amplitude`.
fn noisy_step(height: f32, amplitude: f32) -> Image<f32> {
    let mut state = 7u64;
    Image::from_fn(SIZE.0, SIZE.1, |x, _| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let noise = (state >> 40) as f32 / (1u64 << 23) as f32 - 1.0;
        amplitude * noise + if x < 30 { 0.0 } else { height }
    })
}

/// Valid but for a block, a corner and a column.
fn holes() -> Image<u8> {
    Image::from_fn(SIZE.0, SIZE.1, |x, y| {
        let is_hole = (10..33).contains(&x) && (8..30).contains(&y) || x + y < 9 || x == 50;
        u8::from(!is_hole)
    })
}

fn filtered(image: &Image<f32>, valid: &Image<u8>, params: &GuidedFilterParams) -> Image<f32> {
    let mut filtered = Image::filled(image.width(), image.height(), f32::NAN);
    GuidedFilter::new(image.width(), image.height(), params).unwrap().filter_into(image, valid, &mut filtered);
    filtered
}

fn all_valid() -> Image<u8> {
    Image::filled(SIZE.0, SIZE.1, 1)
}

#[test]
fn windows_follow_the_definition() {
    let image = noisy_step(0.2, 0.05);
    for (radius_px, subsample) in [(1, 1), (5, 1), (8, 4), (9, 3), (40, 7)] {
        for valid in [all_valid(), holes()] {
            let params = GuidedFilterParams { radius_px, epsilon: 1e-3, subsample };
            let (fast, slow) = (filtered(&image, &valid, &params), by_definition(&image, &valid, &params));
            for (i, (&fast, slow)) in fast.values().iter().zip(slow).enumerate() {
                let (x, y) = (i % SIZE.0, i / SIZE.0);
                assert!((f64::from(fast) - slow).abs() < 1e-6, "{params:?} at ({x}, {y}): {fast}, not {slow}");
            }
        }
    }
}

#[test]
fn an_edge_stays_and_noise_goes() {
    for subsample in [1, 4] {
        let params = GuidedFilterParams { subsample, ..GuidedFilterParams::default() };
        let step = filtered(&noisy_step(0.3, 0.005), &all_valid(), &params);
        for y in 0..SIZE.1 {
            let edge = step.at(30, y) - step.at(29, y);
            assert!(edge > 0.27, "subsample {subsample}: the step of 0.3 became {edge} in row {y}");
            assert!(step.at(10, y).abs() < 0.002, "subsample {subsample}: noise of {} in row {y}", step.at(10, y));
        }
    }
}

#[test]
fn a_constant_stays() {
    for value in [0.0, -0.3, 1000.0] {
        let image = filtered(&Image::filled(SIZE.0, SIZE.1, value), &holes(), &GuidedFilterParams::default());
        for (&filtered, &valid) in image.values().iter().zip(holes().values()) {
            let expected = if valid == 1 { value } else { 0.0 };
            assert!((filtered - expected).abs() <= 1e-6 * value.abs(), "{value} became {filtered}");
        }
    }
}

#[test]
fn what_does_not_hold_reaches_no_other_pixel() {
    let (clean, valid) = (noisy_step(0.2, 0.05), holes());
    let broken = [f32::NAN, f32::INFINITY, -1e30];
    let dirty = Image::from_fn(SIZE.0, SIZE.1, |x, y| {
        if valid.at(x, y) == 1 { clean.at(x, y) } else { broken[(x + y) % broken.len()] }
    });
    let params = GuidedFilterParams::default();
    assert_eq!(filtered(&clean, &valid, &params), filtered(&dirty, &valid, &params));
    let nothing = filtered(&dirty, &Image::filled(SIZE.0, SIZE.1, 0), &params);
    assert!(nothing.values().iter().all(|&value| value == 0.0));
}

#[test]
fn every_instruction_set_gives_the_same_bits() {
    let (image, valid, params) = (noisy_step(0.2, 0.05), holes(), GuidedFilterParams::default());
    let mut baseline = Image::filled(SIZE.0, SIZE.1, f32::NAN);
    let mut filter = GuidedFilter::with_level(SIZE.0, SIZE.1, &params, Level::baseline()).unwrap();
    filter.filter_into(&image, &valid, &mut baseline);
    assert_eq!(baseline, filtered(&image, &valid, &params));
}

#[test]
fn a_value_out_of_range_is_named() {
    let params = GuidedFilterParams { radius_px: 3, ..GuidedFilterParams::default() };
    let error = params.validate().unwrap_err().to_string();
    assert_eq!(error, "density.filter.subsample = 4 is out of range: 1 to radius_px, px");
    let error = GuidedFilterParams { epsilon: 0.0, ..params }.validate().unwrap_err();
    assert_eq!(error.key, "density.filter.epsilon");
}

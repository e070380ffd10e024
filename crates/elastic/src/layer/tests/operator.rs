use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};

use super::super::half_space::influence;
use super::super::transform::good_length;
use super::*;

fn grid(columns: usize, rows: usize, cell_mm: f64) -> SurfaceGrid {
    SurfaceGrid { columns, rows, cell_mm }
}

fn noise(grid: SurfaceGrid, seed: u64) -> Vec<[f64; 3]> {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mut value = || f64::from(rng.next_u32()) / f64::from(u32::MAX) - 0.5;
    (0..grid.len()).map(|_| [(); 3].map(|()| value())).collect()
}

fn displacement(layer: &Layer, grid: SurfaceGrid, traction: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut displacement = vec![[f64::NAN; 3]; grid.len()];
    LayerOperator::new(layer, grid).unwrap().displacement_into(traction, &mut displacement);
    displacement
}

fn dot(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| a * b).sum()
}

/// Sum over waves of the spectrum of a Gaussian of uniform cells: what the operator must give, without its grid.
///
/// Steps between cells repeat the Gaussian's spectrum around the multiples of `2π / cell`. Along the axes the first few
/// count; across, they are of higher order.
fn by_waves(layer: &Layer, sigma: f64, cell: f64, traction: [f64; 3], [x, y]: [f64; 2]) -> [f64; 3] {
    let period = 24.0 * layer.thickness_mm();
    let step = std::f64::consts::TAU / period;
    let last = (6.0 / sigma / step) as i32;
    let repeats = (-6..=6).flat_map(|m| if m == 0 { vec![(0, 0)] } else { vec![(m, 0), (0, m)] });
    let waves =
        repeats.flat_map(|repeat| (-last..=last).flat_map(move |i| (-last..=last).map(move |j| (repeat, i, j))));
    let mut sum = [0.0; 3];
    for ((m, n), i, j) in waves {
        let (kx, ky) = (f64::from(i) * step, f64::from(j) * step);
        let gauss = std::f64::consts::TAU * sigma.powi(2) * (-0.5 * sigma.powi(2) * (kx * kx + ky * ky)).exp();
        let shifted = |k: f64, m: i32| k + f64::from(m) * std::f64::consts::TAU / cell;
        let (kx, ky) = (shifted(kx, m), shifted(ky, n));
        let sinc = |k: f64| if k == 0.0 { 1.0 } else { (0.5 * k * cell).sin() / (0.5 * k * cell) };
        let weight = gauss * sinc(kx) * sinc(ky) / (period * period);
        let (sin, cos) = (kx * x + ky * y).sin_cos();
        let matrix = layer.compliance([kx, ky]);
        for (sum, row) in sum.iter_mut().zip(matrix) {
            let value: fingervision_fourier::Complex64 = row.into_iter().zip(traction).map(|(u, t)| u * t).sum();
            *sum += weight * (value.re * cos - value.im * sin);
        }
    }
    sum
}

#[test]
fn the_grid_gives_what_the_sum_over_waves_gives() {
    let (sigma, cell) = (0.5, 0.0625);
    for (nu, thickness_mm) in [(0.0, 1.0), (0.35, 2.0), (0.48, 2.0)] {
        let layer = Layer::new(&GelBlock { thickness_mm, ..block(nu) }).unwrap();
        let grid = grid(101, 98, cell);
        let centres: Vec<_> = grid.centres_mm().collect();
        let at = centres[49 * 101 + 50];
        let traction = [0.3, -0.2, 0.5];
        let field: Vec<_> = centres
            .iter()
            .map(|[x, y]| {
                let gauss = (-0.5 * ((x - at[0]).powi(2) + (y - at[1]).powi(2)) / (sigma * sigma)).exp();
                traction.map(|t| gauss * t)
            })
            .collect();
        let displacement = displacement(&layer, grid, &field);
        let largest = displacement[49 * 101 + 50][2];
        for cell_index in [49 * 101 + 50, 61 * 101 + 55, 40 * 101 + 20, 97 * 101] {
            let [x, y] = centres[cell_index];
            let expected = by_waves(&layer, sigma, cell, traction, [x - at[0], y - at[1]]);
            for (value, expected) in displacement[cell_index].into_iter().zip(expected) {
                let difference = (value - expected).abs() / largest;
                assert!(difference < 5e-6, "ν {nu} at {x}, {y}: {value}, expected {expected}, {difference:.1e}");
            }
        }
    }
}

#[test]
fn a_cell_s_influence_is_the_integral_of_point_forces() {
    let (nu, side) = (0.3_f64, 0.5);
    for offset in [[0.75, 0.1], [-1.0, 2.0], [0.0, -0.6]] {
        let count = 200;
        let place = |index: i32| ((f64::from(index) + 0.5) / f64::from(count) - 0.5) * side;
        let mut sum = [0.0; 6];
        for (i, j) in (0..count).flat_map(|i| (0..count).map(move |j| (i, j))) {
            let (x, y) = (offset[0] - place(i), offset[1] - place(j));
            let r = x.hypot(y);
            let part = [
                (1.0 - nu) / r + nu * x * x / r.powi(3),
                nu * x * y / r.powi(3),
                (1.0 - nu) / r + nu * y * y / r.powi(3),
                -0.5 * (1.0 - 2.0 * nu) * x / (r * r),
                -0.5 * (1.0 - 2.0 * nu) * y / (r * r),
                (1.0 - nu) / r,
            ];
            sum = std::array::from_fn(|index| sum[index] + part[index]);
        }
        let scale = side * side / f64::from(count * count) / std::f64::consts::TAU;
        let given = influence(offset, side, nu);
        let given = [given.xx, given.xy, given.yy, given.xz, given.yz, given.zz];
        for (given, sum) in given.into_iter().zip(sum) {
            assert!((given - scale * sum).abs() < 2e-6, "{offset:?}: {given}, expected {}", scale * sum);
        }
    }
    // Love: a square pressed uniformly goes down at its centre by 4 ln(1 + √2) side (1 − ν) / 2πμ.
    let centre = 4.0 * (1.0 + 2.0_f64.sqrt()).ln() * side * (1.0 - nu) / std::f64::consts::TAU;
    assert_near(influence([0.0; 2], side, nu).zz, centre, 1e-14, "centre");
}

#[test]
fn the_operator_is_symmetric_and_positive() {
    for layer in [layer(0.0), layer(0.35), layer(0.499), half_space(0.2)] {
        let grid = grid(23, 30, 0.8);
        let (a, b) = (noise(grid, 1), noise(grid, 2));
        let (by_a, by_b) = (displacement(&layer, grid, &a), displacement(&layer, grid, &b));
        let scale = dot(&a, &by_a);
        assert!((dot(&a, &by_b) - dot(&b, &by_a)).abs() < 1e-13 * scale, "reciprocity");
        assert!(scale > 0.0 && dot(&b, &by_b) > 0.0);
        let mut operator = LayerOperator::new(&layer, grid).unwrap();
        let (mut back_a, mut back_b) = (a.clone(), a.clone());
        operator.precondition_into(&a, &mut back_a);
        operator.precondition_into(&b, &mut back_b);
        let scale = dot(&a, &back_a);
        assert!((dot(&a, &back_b) - dot(&b, &back_a)).abs() < 1e-13 * scale, "reciprocity of the inverse");
        assert!(scale > 0.0 && dot(&b, &back_b) > 0.0);
        operator.depth_into(&a, &mut back_a);
        let pressure: Vec<_> = a.iter().map(|value| [0.0, 0.0, value[2]]).collect();
        for (depth, whole) in back_a.iter().zip(displacement(&layer, grid, &pressure)) {
            assert!((depth[2] - whole[2]).abs() < 1e-12 * scale);
        }
    }
}

#[test]
fn no_image_of_the_grid_is_seen() {
    // The same tractions on a much larger grid, for kernels that end inside the grid and that do not.
    for (thickness_mm, cell) in [(0.5, 0.25), (2.0, 0.25), (10.0, 0.5), (f64::INFINITY, 0.5)] {
        let layer = match thickness_mm {
            f64::INFINITY => half_space(0.4),
            _ => Layer::new(&GelBlock { thickness_mm, ..block(0.4) }).unwrap(),
        };
        let (small, large) = (grid(60, 31, cell), grid(160, 91, cell));
        let traction = noise(small, 3);
        let mut padded = vec![[0.0; 3]; large.len()];
        for (index, value) in traction.iter().enumerate() {
            padded[(index / 60 + 30) * 160 + index % 60 + 50] = *value;
        }
        let (near, far) = (displacement(&layer, small, &traction), displacement(&layer, large, &padded));
        let scale = near.as_flattened().iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        for (index, value) in near.iter().enumerate() {
            let other = far[(index / 60 + 30) * 160 + index % 60 + 50];
            for axis in 0..3 {
                assert!((value[axis] - other[axis]).abs() < 1e-11 * scale, "{thickness_mm} mm, cell {index}");
            }
        }
    }
}

#[test]
fn a_bonded_layer_s_reach_ends() {
    // Just before the kernel is cut off hardly anything is left of the displacement one thickness away.
    for nu in [0.0, 0.35, 0.48, 0.499] {
        let layer = Layer::new(&GelBlock { thickness_mm: 1.0, ..block(nu) }).unwrap();
        let grid = grid(98, 1, 0.25);
        for axis in 0..3 {
            let mut traction = vec![[0.0; 3]; 98];
            traction[0][axis] = 1.0;
            let moved = displacement(&layer, grid, &traction);
            let part = moved[95][axis].abs() / moved[4][axis].abs();
            assert!(part < 1e-7, "ν {nu}, axis {axis}: {part:.1e} is left at 23.75 thicknesses");
            assert!(moved[96..].as_flattened().iter().all(|value| value.abs() < 1e-12 * moved[0][axis]), "axis {axis}");
        }
    }
}

#[test]
fn no_call_allocates() {
    let grid = grid(32, 32, 0.5);
    let mut operator = LayerOperator::new(&layer(0.4), grid).unwrap();
    let traction = noise(grid, 4);
    let mut displacement = traction.clone();
    let info = allocation_counter::measure(|| {
        operator.displacement_into(&traction, &mut displacement);
        operator.depth_into(&traction, &mut displacement);
        operator.precondition_into(&traction, &mut displacement);
    });
    assert_eq!(info.count_total, 0);
}

#[test]
fn transforms_have_lengths_of_small_factors() {
    for (least, length) in [(0, 1), (1, 1), (7, 8), (11, 12), (61, 64), (121, 125), (255, 256)] {
        assert_eq!(good_length(least), length);
    }
}

#[test]
fn an_impossible_grid_is_refused() {
    let refusal = |grid: SurfaceGrid| LayerOperator::new(&layer(0.35), grid).unwrap_err();
    for grid in [grid(0, 5, 0.1), grid(5, 0, 0.1), grid(5, 5, 0.0), grid(5, 5, f64::NAN), grid(5, 5, f64::INFINITY)] {
        assert!(matches!(refusal(grid), LayerError::Grid { .. }));
    }
    let coarse = refusal(grid(5, 5, 6.0)).to_string();
    assert_eq!(coarse, "cells of 6 mm are too coarse for a layer of 10 mm: half of that is the most");
}

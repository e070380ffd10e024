use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};

use super::inverse::invert;
use super::*;
use crate::fem::{Assembly, BlockMesh, Material};
use crate::layer::{Layer, LayerError, LayerOperator, SurfaceGrid};
use crate::solver::{Multigrid, Solver, Stop};
use crate::{GelBlock, Law};

type Field = Vec<[f32; 3]>;

fn block(size_mm: [f64; 2], poissons_ratio: f64) -> GelBlock {
    GelBlock { size_mm, thickness_mm: 10.0, poissons_ratio, youngs_modulus_mpa: None }
}

fn noise(grid: SurfaceGrid, seed: u64) -> Field {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mut value = || (f64::from(rng.next_u32()) / f64::from(u32::MAX) - 0.5) as f32;
    (0..grid.len()).map(|_| [(); 3].map(|()| value())).collect()
}

/// A smooth hump of traction 4 mm wide.
fn hump(grid: SurfaceGrid, centre_mm: [f64; 2], traction: [f32; 3]) -> Field {
    let share = |[x, y]: [f64; 2]| {
        let r = (x - centre_mm[0]).hypot(y - centre_mm[1]) / 4.0;
        if r < 1.0 { (0.5 * std::f64::consts::PI * r).cos().powi(2) as f32 } else { 0.0 }
    };
    grid.centres_mm().map(|centre| traction.map(|t| t * share(centre))).collect()
}

fn moved(operator: &mut BlockOperator, traction: &[[f32; 3]]) -> Field {
    let mut displacement = vec![[f32::NAN; 3]; operator.grid().len()];
    operator.displacement_into(traction, &mut displacement);
    displacement
}

fn in_layer(block: &GelBlock, grid: SurfaceGrid, traction: &[[f32; 3]]) -> Field {
    let layer = Layer::of_unit_modulus(block).unwrap();
    let traction: Vec<_> = traction.iter().map(|t| t.map(f64::from)).collect();
    let mut displacement = vec![[f64::NAN; 3]; grid.len()];
    LayerOperator::new(&layer, grid).unwrap().displacement_into(&traction, &mut displacement);
    displacement.into_iter().map(|u| u.map(|value| value as f32)).collect()
}

fn dot(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| f64::from(a * b)).sum()
}

/// Norm of the difference over the norm of what is expected.
fn difference(values: &[[f32; 3]], expected: &[[f32; 3]]) -> f64 {
    let rest: Field = values.iter().zip(expected).map(|(a, b)| [0, 1, 2].map(|c| a[c] - b[c])).collect();
    (dot(&rest, &rest) / dot(expected, expected)).sqrt()
}

/// Finite elements on cells of `cell_mm`: displacement of the inner nodes of the surface, which are the cells' centres.
fn by_elements(block: &GelBlock, grid: SurfaceGrid, traction: &[[f32; 3]]) -> Field {
    let lines = |size: f64, from: f64| {
        let count = (size / grid.cell_mm).round() as usize;
        (0..=count).map(|n| from + size * n as f64 / count as f64).collect::<Vec<_>>()
    };
    let across = |size: f64| lines(size, -0.5 * size);
    let mesh = BlockMesh::new(across(block.size_mm[0]), across(block.size_mm[1]), lines(block.thickness_mm, 0.0));
    let material = Material::new(Law::Linear, 2.0 * (1.0 + block.poissons_ratio), block.poissons_ratio);
    let assembly = Assembly::new(mesh, material);
    let nodes = assembly.grid;
    let field = || vec![[0.0; 3]; nodes.len()];
    let mut load = field();
    let inner = |cell: usize| nodes.index(cell % grid.columns + 1, cell / grid.columns + 1, 0);
    for (cell, traction) in traction.iter().enumerate() {
        load[inner(cell)] = traction.map(|t| f64::from(t) * grid.cell_area_mm2());
    }
    let lines = assembly.mesh.lines();
    let mut multigrid = Multigrid::new([lines[0], lines[1], &lines[2][..nodes.nodes[2]]], block.thickness_mm);
    let (mut displacement, mut forces, mut step) = (field(), field(), field());
    assembly.tangent_into(&displacement, multigrid.finest_mut()).unwrap();
    multigrid.refresh();
    for _ in 0..2 {
        assembly.forces_into(&displacement, &mut forces).unwrap();
        let right: Vec<_> = load.iter().zip(&forces).map(|(l, f)| [0, 1, 2].map(|c| l[c] - f[c])).collect();
        let stop = Stop { goal: 0.0, tolerance: 1e-3, limit: 100 };
        Solver::new(nodes).solve(&mut multigrid, (&right, &mut step), &|_| (), stop);
        for (sum, step) in displacement.iter_mut().zip(&step) {
            *sum = [0, 1, 2].map(|c| sum[c] + step[c]);
        }
    }
    (0..grid.len()).map(|cell| displacement[inner(cell)].map(|value| value as f32)).collect()
}

#[test]
fn a_load_near_a_side_moves_the_surface_as_finite_elements_do() {
    let block = block([30.0, 25.0], 0.48);
    let grid = SurfaceGrid { columns: 47, rows: 39, cell_mm: 0.625 };
    let mut operator = BlockOperator::new(&block, grid).unwrap();
    for (centre_mm, traction, least_without) in [
        ([0.0, 0.0], [0.0, 0.0, 0.1], 0.1),
        ([-9.0, 6.0], [0.07, -0.05, 0.05], 0.3),
        ([13.0, 0.0], [0.0, 0.0, 0.1], 0.5),
    ] {
        let load = hump(grid, centre_mm, traction);
        let truth = by_elements(&block, grid, &load);
        let displacement = moved(&mut operator, &load);
        let with_sides = difference(&displacement, &truth);
        let without = difference(&in_layer(&block, grid, &load), &truth);
        assert!(with_sides < 0.035, "load at {centre_mm:?}: {with_sides:.3} off");
        assert!(without > least_without, "load at {centre_mm:?}: without the sides only {without:.3} off");
        // Not only on the whole: farther than 5 mm from the load nowhere by much, next to the sides neither.
        let largest = truth.as_flattened().iter().fold(0.0_f32, |most, value| most.max(value.abs()));
        for ((place, found), truth) in grid.centres_mm().zip(&displacement).zip(&truth) {
            if (place[0] - centre_mm[0]).hypot(place[1] - centre_mm[1]) > 5.0 {
                let error = (0..3).fold(0.0_f32, |most, c| most.max((found[c] - truth[c]).abs()));
                assert!(error < 0.03 * largest, "load at {centre_mm:?}, {place:?}: {found:?}, expected {truth:?}");
            }
        }
    }
}

#[test]
fn the_operator_is_symmetric_and_positive() {
    for nu in [0.3, 0.499] {
        let grid = SurfaceGrid { columns: 30, rows: 25, cell_mm: 0.5 };
        let mut operator = BlockOperator::new(&block([15.0, 12.5], nu), grid).unwrap();
        // Neighbouring cells of noise cancel: a hump is what the sides act on.
        let fields =
            [noise(grid, 1), hump(grid, [5.0, -2.0], [1.0, -0.5, 0.7]), hump(grid, [0.0, 3.0], [0.2, 1.0, -1.0])];
        let images = fields.each_ref().map(|field| moved(&mut operator, field));
        for (a, b) in (0..9).map(|n| (n / 3, n % 3)) {
            let scale = (dot(&fields[a], &images[a]) * dot(&fields[b], &images[b])).sqrt();
            let asymmetry = (dot(&fields[a], &images[b]) - dot(&fields[b], &images[a])).abs();
            assert!(scale > 0.0 && asymmetry < 2e-6 * scale, "ν {nu}, fields {a}, {b}: {asymmetry:.1e} of {scale:.1e}");
        }
    }
}

#[test]
fn far_sides_change_nothing_in_the_middle() {
    let grid = SurfaceGrid { columns: 40, rows: 40, cell_mm: 0.5 };
    let flat = |size: f64| GelBlock { thickness_mm: 2.0, ..block([size, size], 0.48) };
    let load = hump(grid, [0.0; 2], [0.05, 0.0, 0.1]);
    let change = |size: f64| {
        let mut operator = BlockOperator::new(&flat(size), grid).unwrap();
        difference(&moved(&mut operator, &load), &in_layer(&flat(size), grid, &load))
    };
    // Coarse cells of 1.25 mm hold the influence of 2 mm of gel no better.
    assert!(change(30.0) < 4e-3, "{:.1e}", change(30.0));
    assert!(change(11.0) > 0.02, "{:.1e}", change(11.0));
}

#[test]
fn a_mirrored_load_moves_the_mirrored_surface() {
    let grid = SurfaceGrid { columns: 28, rows: 21, cell_mm: 0.5 };
    let mut operator = BlockOperator::new(&block([14.0, 10.5], 0.45), grid).unwrap();
    let load = noise(grid, 5);
    for plane in 0..2 {
        let mirrored = |field: &[[f32; 3]]| -> Field {
            let from = |index: usize| {
                let (i, j) = (index % grid.columns, index / grid.columns);
                let [i, j] = if plane == 0 { [grid.columns - 1 - i, j] } else { [i, grid.rows - 1 - j] };
                let mut value = field[j * grid.columns + i];
                value[plane] = -value[plane];
                value
            };
            (0..grid.len()).map(from).collect()
        };
        let (one, other) = (moved(&mut operator, &mirrored(&load)), mirrored(&moved(&mut operator, &load)));
        assert!(difference(&one, &other) < 1e-5, "plane {plane}: {:.1e}", difference(&one, &other));
    }
}

#[test]
fn a_block_turned_by_a_quarter_turns_the_displacement() {
    let (grid, turned) =
        (SurfaceGrid { columns: 36, rows: 20, cell_mm: 0.5 }, SurfaceGrid { columns: 20, rows: 36, cell_mm: 0.5 });
    let load = hump(grid, [5.0, -2.0], [0.3, -0.2, 1.0]);
    // (x, y) becomes (−y, x).
    let turn = |field: &[[f32; 3]]| -> Field {
        let from = |index: usize| {
            let (i, j) = (index % turned.columns, index / turned.columns);
            let [x, y, z] = field[(grid.rows - 1 - i) * grid.columns + j];
            [-y, x, z]
        };
        (0..grid.len()).map(from).collect()
    };
    let one = moved(&mut BlockOperator::new(&block([18.0, 10.0], 0.48), grid).unwrap(), &load);
    let other = moved(&mut BlockOperator::new(&block([10.0, 18.0], 0.48), turned).unwrap(), &turn(&load));
    assert!(difference(&other, &turn(&one)) < 1e-5, "{:.1e}", difference(&other, &turn(&one)));
}

#[test]
fn no_poissons_ratio_and_no_shape_breaks_it() {
    for (size, nu) in [([12.0, 12.0], 0.0), ([12.0, 12.0], 0.3), ([12.0, 9.0], 0.49), ([4.0, 15.0], 0.499)] {
        let grid = SurfaceGrid { columns: 24, rows: 24, cell_mm: 0.5 };
        let mut operator = BlockOperator::new(&block(size, nu), grid).unwrap();
        let load = hump(grid, [0.0; 2], [0.0, 0.1, 0.1]);
        let displacement = moved(&mut operator, &load);
        let work = dot(&load, &displacement);
        assert!(displacement.as_flattened().iter().all(|value| value.is_finite()) && work > 0.0, "{size:?}, ν {nu}");
    }
}

#[test]
fn the_rough_inverse_brings_conjugate_gradients_to_the_traction() {
    let grid = SurfaceGrid { columns: 40, rows: 40, cell_mm: 0.5 };
    let mut operator = BlockOperator::new(&block([20.0, 20.0], 0.48), grid).unwrap();
    let expected = hump(grid, [5.0, 2.0], [0.03, 0.0, 0.1]);
    let mut residual = moved(&mut operator, &expected);
    let start = dot(&residual, &residual);
    let (mut solution, mut rough) = (vec![[0.0; 3]; grid.len()], vec![[0.0; 3]; grid.len()]);
    operator.precondition_into(&residual, &mut rough);
    let (mut direction, mut slope) = (rough.clone(), dot(&residual, &rough));
    for _ in 0..30 {
        let image = moved(&mut operator, &direction);
        let step = (slope / dot(&direction, &image)) as f32;
        add(&mut solution, step, &direction);
        add(&mut residual, -step, &image);
        operator.precondition_into(&residual, &mut rough);
        let next = dot(&residual, &rough);
        let previous = std::mem::replace(&mut direction, rough.clone());
        add(&mut direction, (next / slope) as f32, &previous);
        slope = next;
    }
    let left = (dot(&residual, &residual) / start).sqrt();
    assert!(left < 1e-3, "{left:.1e} of the displacement is left");
    assert!(difference(&solution, &expected) < 0.02, "{}", difference(&solution, &expected));
}

fn add(sum: &mut [[f32; 3]], factor: f32, values: &[[f32; 3]]) {
    for (sum, value) in sum.as_flattened_mut().iter_mut().zip(values.as_flattened()) {
        *sum += factor * value;
    }
}

#[test]
fn no_call_allocates_and_another_grid_needs_no_new_block() {
    let grid = SurfaceGrid { columns: 24, rows: 24, cell_mm: 0.5 };
    let block = block([12.0, 12.0], 0.48);
    let coarse = BlockOperator::new(&block, SurfaceGrid { columns: 12, rows: 12, cell_mm: 1.0 }).unwrap();
    let mut operator = coarse.on_grid(grid).unwrap();
    let load = noise(grid, 7);
    let mut displacement = load.clone();
    let info = allocation_counter::measure(|| {
        operator.precondition_into(&load, &mut displacement);
        operator.displacement_into(&load, &mut displacement);
    });
    assert_eq!(info.count_total, 0);
    assert_eq!(displacement, moved(&mut BlockOperator::new(&block, grid).unwrap(), &load));
    let error = coarse.on_grid(SurfaceGrid { cell_mm: 6.0, ..grid }).unwrap_err();
    assert!(matches!(error, LayerError::Coarse { .. }));
}

#[test]
fn an_inverse_times_its_matrix_is_one() {
    for size in [1, 7, 8, 29] {
        let mut rng = Pcg64Mcg::seed_from_u64(size as u64);
        let factor: Vec<f64> =
            (0..size * size).map(|_| f64::from(rng.next_u32()) / f64::from(u32::MAX) - 0.5).collect();
        let at = |r: usize, c: usize| {
            let product: f64 = (0..size).map(|n| factor[r * size + n] * factor[c * size + n]).sum();
            product + f64::from(u8::from(r == c))
        };
        let mut inverse: Vec<f64> = (0..size * size).map(|n| at(n / size, n % size)).collect();
        invert(&mut inverse, size);
        for (r, c) in (0..size * size).map(|n| (n / size, n % size)) {
            let product: f64 = (0..size).map(|n| at(r, n) * inverse[n * size + c]).sum();
            assert!((product - f64::from(u8::from(r == c))).abs() < 1e-12, "size {size}, {r}, {c}: {product}");
        }
    }
}

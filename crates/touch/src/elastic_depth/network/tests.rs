//! Tests of the network.

use super::convolution::Convolution;
use super::finish::Activation;
use super::global_context::GlobalContext;
use super::plane::Plane;
use super::shape::Shape;
use super::*;

/// Numbers without a pattern, from −1 to 1.
fn scatter(seed: usize) -> f32 {
    let mixed = (seed as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    ((mixed ^ (mixed >> 29)) % 20_001) as f32 / 10_000.0 - 1.0
}

fn filled(size: (usize, usize), channels: usize) -> Plane {
    let mut plane = Plane::new(size, channels);
    for row in 0..size.1 {
        for (at, value) in plane.row_mut(row).iter_mut().enumerate() {
            *value = scatter(1000 * row + at);
        }
    }
    plane
}

/// A layer computed by its definition, one sum at a time.
fn slow(shape: Shape, values: &[f32], from: &Plane, (column, row): (usize, usize), output: usize) -> f64 {
    let Shape { inputs, outputs, side, stride } = shape;
    let mut sum = f64::from(values[outputs * inputs * side * side + output]);
    for (tap_row, tap_column) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
        let inside = |place: usize, count: usize| place.checked_sub(side / 2).filter(|&place| place < count);
        let y = inside(row * stride + tap_row, from.rows);
        let x = inside(column * stride + tap_column, from.columns);
        let (Some(x), Some(y)) = (x, y) else { continue };
        for input in 0..inputs {
            let weight = values[((output * inputs + input) * side + tap_row) * side + tap_column];
            sum += f64::from(weight) * f64::from(from.row(y)[x * inputs + input]);
        }
    }
    sum
}

#[test]
fn a_layer_is_the_sum_of_its_definition() {
    let shapes = [(3, 1, 5, 16), (3, 2, 7, 20), (1, 1, 6, 8), (3, 1, 16, 33), (3, 1, 22, 16), (3, 1, 64, 4)];
    for ((side, stride, inputs, outputs), size) in
        shapes.into_iter().flat_map(|shape| [(shape, (18, 16)), (shape, (17, 15))])
    {
        let shape = Shape { inputs, outputs, side, stride };
        let values: Vec<_> = (0..shape.len()).map(scatter).collect();
        let from = filled(size, inputs);
        let mut to = Plane::new((size.0 / stride, size.1 / stride), outputs.next_multiple_of(LANES));
        Convolution::new(shape, &values).apply(Level::new(), &Team::default(), &from, &mut to, Activation::Keep);
        for (row, column) in (0..to.rows).flat_map(|row| (0..to.columns).map(move |column| (row, column))) {
            let output = (row + column) % outputs;
            let expected = slow(shape, &values, &from, (column, row), output);
            let found = f64::from(to.row(row)[column * to.channels + output]);
            let is_near = (found - expected).abs() < 1e-5 * (1.0 + expected.abs());
            assert!(is_near, "{shape:?} {size:?} at {column}, {row}: {found} {expected}");
        }
    }
}

#[test]
fn two_threads_give_the_same_bits() {
    let input = |column: usize, row: usize| std::array::from_fn(|k| 0.1 * scatter(977 * row + 31 * column + k));
    for size in [(120, 120), (120, 104), (72, 64)] {
        let run = |team: &Team| {
            let mut network = ContactNetwork::new(size);
            network.share(team);
            let mut results = Vec::new();
            for weights in [Weights::Whole, Weights::WithoutDrag] {
                let write = |_, _, outputs: [f32; OUTPUTS]| results.extend(outputs.map(f32::to_bits));
                team.run(|| network.run(weights, [0.2, 0.0], input, write));
            }
            results
        };
        let team = Team::new(2).unwrap();
        assert!(team.is_shared());
        assert_eq!(run(&team), run(&Team::default()), "{size:?}");
    }
}

#[test]
fn a_layer_that_adds_keeps_what_went_in() {
    let shape = Shape { inputs: 16, outputs: 16, side: 3, stride: 1 };
    let from = filled((8, 8), 16);
    let mut to = Plane::new((8, 8), 16);
    Convolution::new(shape, &vec![0.0; shape.len()]).apply(
        Level::new(),
        &Team::default(),
        &from,
        &mut to,
        Activation::RectifyAndAdd,
    );
    assert_eq!(to.row(3), from.row(3));
}

#[test]
fn a_coarser_plane_is_added_to_two_by_two_cells() {
    let shape = Shape { inputs: 16, outputs: 16, side: 3, stride: 1 };
    let (from, coarse) = (filled((8, 8), 16), filled((4, 4), 16));
    let mut to = Plane::new((8, 8), 16);
    let layer = Convolution::new(shape, &vec![0.0; shape.len()]);
    layer.apply(Level::new(), &Team::default(), &from, &mut to, Activation::AddGrownAndRectify(&coarse));
    for (row, column) in [(0, 0), (3, 6), (7, 7)] {
        let grown = coarse.row(row / 2)[column / 2 * 16..][..16].iter().map(|value| value.max(0.0));
        assert!(to.row(row)[column * 16..][..16].iter().copied().eq(grown), "row {row}, column {column}");
    }
}

#[test]
fn every_cell_network_applies_the_mean_over_all() {
    let values: Vec<_> = (0..GlobalContext::len(16)).map(scatter).collect();
    let before = filled((9, 7), 16);
    let mut after = before.clone();
    GlobalContext::new(16, &values).apply(&mut after);
    let mean = |channel: usize| {
        let cells = (0..7).flat_map(|row| before.row(row).iter().skip(channel).step_by(16));
        cells.map(|&value| f64::from(value)).sum::<f64>() / 63.0
    };
    for (row, column, output) in [(0, 0, 0), (3, 8, 7), (6, 4, 15)] {
        let change: f64 = (0..16).map(|input| f64::from(values[16 * output + input]) * mean(input)).sum();
        let at = 16 * column + output;
        let expected = (f64::from(before.row(row)[at]) + change + f64::from(values[256 + output])).max(0.0);
        assert!((f64::from(after.row(row)[at]) - expected).abs() < 1e-5, "{expected}");
    }
}

#[test]
fn every_symmetry_and_its_inverse_give_the_same_cell() {
    assert_eq!(Symmetry::all((72, 64)).len(), 4);
    let symmetries = Symmetry::all((72, 72));
    assert_eq!(symmetries.len(), 8);
    for way in symmetries {
        // A motion that grows from the middle looks the same under every symmetry.
        let middle = |place: (usize, usize)| [place.0 as f32 - 35.5, place.1 as f32 - 35.5];
        for place in [(0, 0), (71, 3), (20, 50)] {
            let [x, y] = middle(way.place((72, 72), place));
            assert_eq!(way.inputs([x, y, x, y, 1.0])[..2], middle(place), "{way:?} at {place:?}");
        }
        let seen: std::collections::HashSet<_> =
            (0..72).flat_map(|row| (0..72).map(move |column| way.place((72, 72), (column, row)))).collect();
        assert_eq!(seen.len(), 72 * 72, "{way:?} shows every cell once");
    }
}

#[test]
fn instruction_sets_differ_by_rounding_alone() {
    let run = |level: Level| {
        let mut network = ContactNetwork::new((72, 64));
        network.level = level;
        let mut results = Vec::new();
        let input = |column: usize, row: usize| std::array::from_fn(|k| 0.1 * scatter(977 * row + 31 * column + k));
        for weights in [Weights::Whole, Weights::WithoutDrag] {
            network.run(weights, [0.2, 0.0], input, |_, _, outputs| results.extend(outputs));
        }
        results
    };
    let (best, baseline) = (run(Level::new()), run(Level::baseline()));
    assert_eq!(best.len(), 2 * 3 * 72 * 64);
    for (best, baseline) in best.iter().zip(&baseline) {
        assert!((best - baseline).abs() < 1e-4 * (1.0 + baseline.abs()), "{best} {baseline}");
    }
}

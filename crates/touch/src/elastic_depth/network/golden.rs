//! The forward pass against that of `PyTorch` with the same weights, as `learn/golden.py` writes it.

use super::{CONSTANTS, ContactNetwork, INPUTS, OUTPUTS, Weights};

const GOLDEN: [(Weights, &[u8]); 2] = [
    (Weights::Whole, include_bytes!("../../../testdata/golden.bin")),
    (Weights::WithoutDrag, include_bytes!("../../../testdata/golden-without-drag.bin")),
];
/// Largest difference, as a part of the channel's largest output: the reference is in double precision, ours in single.
const TOLERANCE: f32 = 1e-5;

#[test]
fn the_forward_pass_is_that_of_pytorch() {
    for (weights, golden) in GOLDEN {
        compare(weights, golden);
    }
}

fn compare(weights: Weights, golden: &[u8]) {
    let (words, []) = golden.as_chunks::<4>() else { panic!("the golden file is whole words") };
    let (size, values) = words.split_at(2);
    let [columns, rows] = [0, 1].map(|i| u32::from_le_bytes(size[i]) as usize);
    let values: Vec<f32> = values.iter().map(|&word| f32::from_le_bytes(word)).collect();
    let (constants, values) = values.split_at(CONSTANTS);
    let (inputs, expected) = values.split_at(INPUTS * rows * columns);
    assert_eq!(expected.len(), OUTPUTS * rows * columns);
    let place = |channel: usize, column: usize, row: usize| (channel * rows + row) * columns + column;
    let mut found = vec![f32::NAN; expected.len()];
    ContactNetwork::new((columns, rows)).run(
        weights,
        [constants[0], constants[1]],
        |column, row| std::array::from_fn(|channel| inputs[place(channel, column, row)]),
        |column, row, outputs| {
            for (channel, output) in outputs.into_iter().enumerate() {
                found[place(channel, column, row)] = output;
            }
        },
    );
    let channels = expected.chunks_exact(rows * columns).zip(found.chunks_exact(rows * columns));
    for (channel, (expected, found)) in channels.enumerate() {
        let largest = expected.iter().fold(0.0, |largest: f32, value| largest.max(value.abs()));
        let differences = expected.iter().zip(found).map(|(expected, found)| (expected - found).abs());
        // A difference that is not a number counts as the largest.
        let worst =
            differences.fold(0.0, |worst: f32, difference| if difference <= worst { worst } else { difference });
        assert!(worst <= TOLERANCE * largest, "{weights:?}, output {channel}: off by {worst:e} of {largest}");
    }
}

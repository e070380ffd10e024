//! Mutated files of weights: layers or none, never a panic.

use fingervision_fuzz::{Form, Parser};

use super::{CONSTANTS, INPUTS, Layers, OUTPUTS};

/// The most memory that a small file may take, bytes.
const MOST_BYTES: u64 = 16 << 20;

/// A file of a network with so few channels that a mutation often hits what is not a weight.
fn small() -> Vec<u8> {
    let [fine, middle, coarse] = [1, 2, 3];
    let layer = |inputs: usize, outputs: usize, side: usize| outputs * (inputs * side * side + 1);
    let enter = layer(4 * INPUTS + CONSTANTS, fine, 3) + layer(fine, fine, 3);
    let down = layer(fine, middle, 3) + layer(middle, middle, 3);
    let deep = layer(middle, coarse, 3) + 2 * layer(coarse, coarse, 3) + layer(coarse, coarse, 1);
    let up = layer(coarse, middle, 1) + 2 * layer(middle, middle, 3);
    let leave = layer(middle, fine, 1) + 2 * layer(fine, fine, 3);
    let count = enter + down + deep + up + leave + layer(fine, 4 * OUTPUTS, 1);
    let sizes = [fine, middle, coarse].map(|channels| channels as u32);
    let weights = (0..count).map(|n| n as f32 / count as f32 - 0.5);
    sizes.into_iter().flat_map(u32::to_le_bytes).chain(weights.flat_map(f32::to_le_bytes)).collect()
}

#[test]
fn mutated_weights_are_read_or_refused() {
    let parser =
        Parser { name: "weights", form: Form::Binary, files: vec![small()], inputs: 20_000, most_bytes: MOST_BYTES };
    parser.run(|bytes| Layers::read(bytes).is_some());
}

#[test]
fn sizes_that_overflow_are_refused() {
    for size in [0, 4097, 0x8000_0000_u32, u32::MAX] {
        let mut file = small();
        file[4..8].copy_from_slice(&size.to_le_bytes());
        assert!(Layers::read(&file).is_none(), "{size} channels");
    }
}

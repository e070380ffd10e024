//! The variance of a patch's displacement from its own pixels alone, without its neighbours.

use super::grid::PatchGrid;
use super::nodes::UNKNOWNS;
use super::symmetric::{PACKED, packed};

/// Sum of the variances of both components of every node's displacement, from its own patch alone, px². `scale` is one
/// over the noise variance and the overlap of the patches.
pub(crate) fn own_variances(
    grid: PatchGrid,
    normal: &[Vec<f32>; PACKED],
    scale: f32,
    slope_stiffness: f32,
    variance: &mut [f32],
) {
    for (node, variance) in variance.iter_mut().enumerate().take(grid.nodes()) {
        *variance = own_variance(|entry| normal[entry][node], scale, slope_stiffness);
    }
}

/// The same for one patch with this packed normal matrix.
pub(crate) fn own_variance(normal: impl Fn(usize) -> f32, scale: f32, slope_stiffness: f32) -> f32 {
    let mut block = [[0.0; UNKNOWNS]; UNKNOWNS];
    for (i, row) in block.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry = f64::from(scale * normal(packed(i, j)));
        }
        row[i] += if i % 3 == 0 { 1e-9 } else { f64::from(slope_stiffness) };
    }
    let [[a, b], [_, c]] = eliminate_slopes(block);
    let trace = (a + c) / (a * c - b * b);
    if trace.is_finite() && trace > 0.0 { trace as f32 } else { f32::MAX }
}

/// The Schur complement of the two values in a symmetric matrix, of which the four slopes are eliminated.
fn eliminate_slopes(mut block: [[f64; UNKNOWNS]; UNKNOWNS]) -> [[f64; 2]; 2] {
    const ORDER: [usize; UNKNOWNS] = [1, 2, 4, 5, 0, 3];
    for (done, &pivot) in ORDER[..4].iter().enumerate() {
        let scale = 1.0 / block[pivot][pivot];
        for &row in &ORDER[done + 1..] {
            let factor = block[row][pivot] * scale;
            for &column in &ORDER[done + 1..] {
                block[row][column] -= factor * block[pivot][column];
            }
        }
    }
    [[block[0][0], block[0][3]], [block[3][0], block[3][3]]]
}

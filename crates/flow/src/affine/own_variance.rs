//! The variance of a patch's displacement from its own pixels alone, without its neighbours.

use super::nodes::UNKNOWNS;
use super::symmetric::packed;

/// Squared gradient of an image that is nothing but noise, relative to the variance of the noise: that of a central
/// difference of an image smoothed by a cubic B-spline.
const NOISE_GRADIENT: f32 = 0.25;

/// Factor on the squared gradient of noise: that of a single patch differs from the expected one by up to a third, and the noise
/// may be half as large again as the parameters say.
const MOST_NOISE: f32 = 2.5;

/// Most squared gradient in a patch of so many samples that noise alone explains, grey levels² per px², for one component of the
/// motion; `variance` is that of the noise of one image.
pub(crate) fn noise_gradient(samples: f32, variance: f32) -> f32 {
    MOST_NOISE * NOISE_GRADIENT * variance * samples
}

/// The part of a patch's squared gradient, 0 to 1, that noise does not explain.
pub(crate) fn signal(normal: impl Fn(usize) -> f32, noise_gradient: f32) -> f32 {
    let both = normal(packed(0, 0)) + normal(packed(3, 3));
    if both > 0.0 { (1.0 - 2.0 * noise_gradient / both).max(0.0) } else { 0.0 }
}

/// Sum of the variances of both components of a patch's displacement, from its own pixels alone, px²; `normal` is its packed
/// normal matrix. `scale` is one over the noise variance and the overlap of the patches. The noise's part of the squared gradient
/// determines nothing.
pub(crate) fn own_variance(
    normal: impl Fn(usize) -> f32,
    noise_gradient: f32,
    scale: f32,
    slope_stiffness: f32,
) -> f32 {
    let mut block = [[0.0; UNKNOWNS]; UNKNOWNS];
    for (i, row) in block.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry = f64::from(scale * normal(packed(i, j)));
        }
        row[i] += if i % 3 == 0 { 1e-9 } else { f64::from(slope_stiffness) };
    }
    let [[a, b], [_, c]] = eliminate_slopes(block);
    let noise = f64::from(scale * noise_gradient);
    let (a, c) = (a - noise, c - noise);
    let trace = (a + c) / (a * c - b * b);
    if a > 0.0 && trace.is_finite() && trace > 0.0 { trace as f32 } else { f32::MAX }
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

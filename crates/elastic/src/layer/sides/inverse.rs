//! The inverse of a symmetric, positive definite matrix.
//!
//! Gauss–Jordan elimination with a block of pivots at a time, on the lower triangle only: half of n³ multiplications. No
//! pivoting is needed, since the rest after each step is again positive definite.

use fearless_simd::{Level, dispatch};

/// Pivots eliminated together.
const BLOCK: usize = 8;

/// Replaces a matrix of `size` rows, whose lower triangle is read, by its inverse.
pub(super) fn invert(matrix: &mut [f64], size: usize) {
    dispatch!(Level::new(), _ => sweep(matrix, size));
    // The sweep leaves the negative of the inverse.
    for row in 0..size {
        for column in 0..=row {
            let value = -matrix[row * size + column];
            matrix[row * size + column] = value;
            matrix[column * size + row] = value;
        }
    }
}

#[inline(always)]
fn sweep(matrix: &mut [f64], size: usize) {
    let mut pivots = vec![0.0; BLOCK * size];
    for first in (0..size).step_by(BLOCK) {
        let count = BLOCK.min(size - first);
        pivots.fill(0.0);
        for (q, pivot) in pivots.chunks_exact_mut(size).take(count).enumerate() {
            let own = first + q;
            pivot[..=own].copy_from_slice(&matrix[own * size..][..=own]);
            for (row, value) in pivot.iter_mut().enumerate().skip(own + 1) {
                *value = matrix[row * size + own];
            }
        }
        let small = small_inverse(&pivots, size, first, count);
        for row in (0..first).chain(first + count..size) {
            let mut factor = [0.0; BLOCK];
            for (q, s) in (0..BLOCK * BLOCK).map(|n| (n % BLOCK, n / BLOCK)) {
                factor[q] += pivots[s * size + row] * small[s][q];
            }
            subtract(&mut matrix[row * size..][..=row], &factor, &pivots, size);
            for (q, factor) in factor.iter().take(count).enumerate() {
                let at = if row > first { row * size + first + q } else { (first + q) * size + row };
                matrix[at] = *factor;
            }
        }
        for (q, s) in (0..count * count).map(|n| (n / count, n % count)) {
            matrix[(first + q) * size + first + s] = -small[q][s];
        }
    }
}

/// `target −= Σ factor_q · pivot row q`.
#[inline(always)]
fn subtract(target: &mut [f64], factor: &[f64; BLOCK], pivots: &[f64], size: usize) {
    let length = target.len();
    let rows: [&[f64]; BLOCK] = std::array::from_fn(|q| &pivots[q * size..][..length]);
    for column in 0..length {
        let mut value = target[column];
        for q in 0..BLOCK {
            value -= factor[q] * rows[q][column];
        }
        target[column] = value;
    }
}

/// Inverse of the block where pivot rows and columns meet; zero beyond `count`.
#[inline(always)]
fn small_inverse(pivots: &[f64], size: usize, first: usize, count: usize) -> [[f64; BLOCK]; BLOCK] {
    let mut a = [[0.0; BLOCK]; BLOCK];
    for (q, s) in (0..count * count).map(|n| (n / count, n % count)) {
        a[q][s] = pivots[q * size + first + s];
    }
    for pivot in 0..count {
        let over = 1.0 / a[pivot][pivot];
        a[pivot][pivot] = 1.0;
        a[pivot].iter_mut().for_each(|value| *value *= over);
        let scaled = a[pivot];
        for row in (0..count).filter(|row| *row != pivot) {
            let factor = std::mem::take(&mut a[row][pivot]);
            for (value, scaled) in a[row].iter_mut().zip(scaled) {
                *value -= factor * scaled;
            }
        }
    }
    a
}

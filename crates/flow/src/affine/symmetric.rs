//! Small symmetric matrices over a node's unknowns.

use super::nodes::UNKNOWNS;

/// Entries of a symmetric matrix over a node's unknowns.
pub(crate) const PACKED: usize = UNKNOWNS * (UNKNOWNS + 1) / 2;

/// Index of entry `(i, j)` of a symmetric matrix in packed storage.
pub(crate) const fn packed(i: usize, j: usize) -> usize {
    let (low, high) = if i < j { (i, j) } else { (j, i) };
    high * (high + 1) / 2 + low
}

/// Inverse of a symmetric positive definite matrix, by Gauss–Jordan without pivoting.
pub(crate) fn invert(mut matrix: [[f64; UNKNOWNS]; UNKNOWNS]) -> [[f64; UNKNOWNS]; UNKNOWNS] {
    let mut inverse: [[f64; UNKNOWNS]; UNKNOWNS] =
        std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    for pivot in 0..UNKNOWNS {
        let scale = 1.0 / matrix[pivot][pivot];
        for k in 0..UNKNOWNS {
            matrix[pivot][k] *= scale;
            inverse[pivot][k] *= scale;
        }
        for row in (0..UNKNOWNS).filter(|&row| row != pivot) {
            let factor = matrix[row][pivot];
            for k in 0..UNKNOWNS {
                matrix[row][k] -= factor * matrix[pivot][k];
                inverse[row][k] -= factor * inverse[pivot][k];
            }
        }
    }
    inverse
}

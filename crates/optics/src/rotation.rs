//! Rotations given by a vector, and 3×3 matrices as arrays of rows.

/// Rows.
pub(crate) type Matrix = [[f64; 3]; 3];

/// Below this angle, rad, the series of `(θ − sin θ) / θ³` is exact to rounding where the formula cancels.
const SMALL_ANGLE_RAD: f64 = 0.1;

/// The rotation about `vector` by its length, rad: Rodrigues' formula
/// `R = I + sin θ / θ [v] + (1 − cos θ) / θ² [v]²`, with `[v] q = v × q`.
#[must_use]
pub fn rotation_matrix(vector: [f64; 3]) -> Matrix {
    let (sine, versine, _) = coefficients(vector);
    series(vector, sine, versine)
}

/// The derivative of the rotation by its vector: `R(v + dv) = R(v) R(J dv)` to first order, with `J = I − (1 − cos θ) /
/// θ² [v] + (θ − sin θ) / θ³ [v]²`.
pub(crate) fn right_jacobian(vector: [f64; 3]) -> Matrix {
    let (_, versine, third) = coefficients(vector);
    series(vector, -versine, third)
}

/// `sin θ / θ`, `(1 − cos θ) / θ²` and `(θ − sin θ) / θ³`.
fn coefficients(vector: [f64; 3]) -> (f64, f64, f64) {
    let squared: f64 = vector.iter().map(|v| v * v).sum();
    let angle = squared.sqrt();
    let sinc = |x: f64| if x == 0.0 { 1.0 } else { x.sin() / x };
    let third = if angle < SMALL_ANGLE_RAD {
        1.0 / 6.0 - squared * (1.0 / 120.0 - squared * (1.0 / 5040.0 - squared / 362_880.0))
    } else {
        (angle - angle.sin()) / (squared * angle)
    };
    (sinc(angle), 0.5 * sinc(0.5 * angle).powi(2), third)
}

/// `I + a [v] + b [v]²`.
fn series(v: [f64; 3], a: f64, b: f64) -> Matrix {
    let cross = cross_matrix(v);
    let square = product(&cross, &cross);
    std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j)) + a * cross[i][j] + b * square[i][j]))
}

/// The matrix of `q ↦ v × q`.
pub(crate) fn cross_matrix([x, y, z]: [f64; 3]) -> Matrix {
    [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
}

/// The rows of `a` times `b`.
pub(crate) fn product<const ROWS: usize>(a: &[[f64; 3]; ROWS], b: &Matrix) -> [[f64; 3]; ROWS] {
    a.map(|row| std::array::from_fn(|j| row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j]))
}

/// `matrix · vector`.
pub(crate) fn apply(matrix: &Matrix, vector: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * vector[0] + row[1] * vector[1] + row[2] * vector[2])
}

/// `matrixᵀ · vector`.
pub(crate) fn apply_transposed(matrix: &Matrix, vector: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|j| matrix[0][j] * vector[0] + matrix[1][j] * vector[1] + matrix[2][j] * vector[2])
}

//! The motion of a face that the gel sticks to.
//!
//! Gel that sticks to a flat face from the first touch moves with it as a rigid body: six numbers give the depth of
//! every point, and the camera sees each point on a ray. With the points at rest `X`, rotated by R and moved by T,
//!
//! ```text
//! (R X + T − X)_xy + a (R X + T)_z = b
//! ```
//!
//! is fitted by Gauss–Newton with Tukey's weights [Huber1981]. Points that match within the noise of the flow belong to
//! the face; for gel outside the face the difference is much larger, because it is strained.

#[cfg(test)]
pub(super) mod tests;

use fingervision_optics::rotation_matrix;

use super::surface::Surface;
use super::thresholds::THRESHOLDS;

/// A rigid motion of gel space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RigidMotion {
    rotation: [[f64; 3]; 3],
    translation_mm: [f64; 3],
}

/// The motion of contact that the gel sticks to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StuckFace {
    pub(super) motion: RigidMotion,
    /// Median distance between a point's ray and its position by the motion, mm.
    pub(super) residual_mm: f64,
    /// The part of the points that match, 0 to 1.
    pub(super) matching: f64,
}

/// Positions of the surface's cells before a motion, mm: those of the gel at rest, or of an earlier frame.
pub(super) trait Positions {
    fn position_mm(&self, surface: &Surface, cell: usize) -> [f64; 3];
}

/// The gel at rest.
#[derive(Debug, Clone, Copy)]
pub(super) struct AtRest;

impl Positions for AtRest {
    fn position_mm(&self, surface: &Surface, cell: usize) -> [f64; 3] {
        let [x, y] = surface.centre_mm(cell);
        [x, y, 0.0]
    }
}

/// A point and its measurement by the camera.
#[derive(Debug, Clone, Copy)]
struct Point {
    /// On the gel at rest.
    rest: [f64; 2],
    /// Before the motion.
    before: [f64; 3],
    apparent: [f64; 2],
    slope: [f64; 2],
}

impl StuckFace {
    /// Whether the points move as a rigid body within this error of the flow, mm.
    pub(super) fn sticks(&self, noise_mm: f64) -> bool {
        self.matching >= THRESHOLDS.least_matching && self.residual_mm <= THRESHOLDS.most_residual * noise_mm
    }
}

/// Largest distance of a point that moves with a face, mm, for this error of the flow, mm.
pub(super) fn tolerance_mm(noise_mm: f64) -> f64 {
    3.0 * noise_mm
}

/// Iterations of reweighting.
const ROUNDS: usize = 8;
/// Least number of points for a fit.
const LEAST_POINTS: usize = 30;

impl RigidMotion {
    const NONE: Self = Self { rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], translation_mm: [0.0; 3] };

    /// Current position of a point of the undeformed surface, mm.
    pub(super) fn apply(&self, [x, y]: [f64; 2]) -> [f64; 3] {
        self.moves([x, y, 0.0])
    }

    /// Position after the motion of a point that was here before it, mm.
    pub(super) fn moves(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let turned = |[a, b, c]: [f64; 3]| a * x + b * y + c * z;
        [0, 1, 2].map(|i| turned(self.rotation[i]) + self.translation_mm[i])
    }

    fn turned(&self, step: [f64; 6]) -> Self {
        let turn = rotation_matrix([step[0], step[1], step[2]]);
        let product = |i: usize, j: usize| (0..3).map(|k| turn[i][k] * self.rotation[k][j]).sum();
        Self {
            rotation: std::array::from_fn(|i| std::array::from_fn(|j| product(i, j))),
            translation_mm: std::array::from_fn(|i| self.translation_mm[i] + step[3 + i]),
        }
    }
}

/// Distance between the position of a cell by a motion and its measured position, mm.
pub(super) fn distance_mm(surface: &Surface, from: &impl Positions, cell: usize, motion: &RigidMotion) -> f64 {
    let [x, y] = residual(&point(surface, from, cell), motion);
    (x * x + y * y).sqrt()
}

/// Fits the motion of a face to some cells of the surface; none if they are too few or do not determine it.
pub(super) fn fit(
    surface: &Surface,
    from: &impl Positions,
    cells: &[usize],
    tolerance_mm: f64,
    scratch: &mut Vec<f64>,
) -> Option<StuckFace> {
    if cells.len() < LEAST_POINTS {
        return None;
    }
    let (mut motion, mut residual_mm, mut scale) = (RigidMotion::NONE, f64::INFINITY, f64::INFINITY);
    for _ in 0..ROUNDS {
        motion = motion.turned(step(surface, from, cells, &motion, scale)?);
        scratch.clear();
        scratch.extend(cells.iter().map(|&cell| distance_mm(surface, from, cell, &motion)));
        let middle = scratch.len() / 2;
        residual_mm = *scratch.select_nth_unstable_by(middle, f64::total_cmp).1;
        scale = scale_of(residual_mm, tolerance_mm);
    }
    let matching = scratch.iter().filter(|&&distance| distance < self::tolerance_mm(tolerance_mm)).count() as f64;
    Some(StuckFace { motion, residual_mm, matching: matching / cells.len() as f64 })
}

/// The residual at which weights vanish, for this median.
fn scale_of(residual_mm: f64, tolerance_mm: f64) -> f64 {
    (1.5 * residual_mm).max(tolerance_mm)
}

/// Standard deviation of the depth in the middle of the points of a fitted face, mm, if each has an independent error
/// of the tolerance: large where the rays are nearly parallel, none where the points do not determine it.
pub(super) fn depth_deviation_mm(
    surface: &Surface,
    from: &impl Positions,
    cells: &[usize],
    face: &StuckFace,
    tolerance_mm: f64,
) -> Option<f64> {
    let motion = &face.motion;
    let (matrix, _) = normal_equations(surface, from, cells, motion, scale_of(face.residual_mm, tolerance_mm));
    let mut middle = [0.0; 2];
    for &cell in cells {
        let to = motion.moves(from.position_mm(surface, cell));
        for axis in 0..2 {
            middle[axis] += (to[axis] - motion.translation_mm[axis]) / cells.len() as f64;
        }
    }
    let along = [middle[1], -middle[0], 0.0, 0.0, 0.0, 1.0];
    let spread = solve(matrix, along)?;
    let variance: f64 = along.iter().zip(spread).map(|(along, spread)| along * spread).sum();
    Some(tolerance_mm * variance.sqrt())
}

fn point(surface: &Surface, from: &impl Positions, cell: usize) -> Point {
    let seen = &surface.seen[cell];
    Point {
        rest: surface.centre_mm(cell),
        before: from.position_mm(surface, cell),
        apparent: seen.apparent_mm.map(f64::from),
        slope: seen.slope.map(f64::from),
    }
}

fn residual(point: &Point, motion: &RigidMotion) -> [f64; 2] {
    let to = motion.moves(point.before);
    [0, 1].map(|axis| to[axis] - point.rest[axis] + point.slope[axis] * to[2] - point.apparent[axis])
}

/// One step of Gauss–Newton with weights for residuals of this scale: a rotation and a translation.
fn step(
    surface: &Surface,
    from: &impl Positions,
    cells: &[usize],
    motion: &RigidMotion,
    scale: f64,
) -> Option<[f64; 6]> {
    let (matrix, right) = normal_equations(surface, from, cells, motion, scale);
    solve(matrix, right)
}

/// The normal equations of a step.
fn normal_equations(
    surface: &Surface,
    from: &impl Positions,
    cells: &[usize],
    motion: &RigidMotion,
    scale: f64,
) -> ([[f64; 6]; 6], [f64; 6]) {
    let (mut matrix, mut right) = ([[0.0; 6]; 6], [0.0; 6]);
    for &cell in cells {
        let point = point(surface, from, cell);
        let [rx, ry] = residual(&point, motion);
        let outlying = (rx * rx + ry * ry) / (3.0 * scale).powi(2);
        let weight = if outlying < 1.0 { (1.0 - outlying).powi(2) } else { 0.0 };
        let to = motion.moves(point.before);
        let [x, y, z] = [0, 1, 2].map(|i| to[i] - motion.translation_mm[i]);
        let [a, b] = point.slope;
        // A small turn w moves the point by w × (x, y, z).
        let rows = [[a * y, z - a * x, -y, 1.0, 0.0, a], [b * y - z, -b * x, x, 0.0, 1.0, b]];
        for (row, residual) in rows.iter().zip([rx, ry]) {
            for i in 0..6 {
                right[i] -= weight * row[i] * residual;
                for j in 0..6 {
                    matrix[i][j] += weight * row[i] * row[j];
                }
            }
        }
    }
    (matrix, right)
}

/// Cholesky; none where the matrix is singular to rounding.
fn solve(mut matrix: [[f64; 6]; 6], mut right: [f64; 6]) -> Option<[f64; 6]> {
    let largest = (0..6).map(|i| matrix[i][i]).fold(0.0, f64::max);
    for i in 0..6 {
        for j in 0..=i {
            let sum = matrix[i][j] - (0..j).map(|k| matrix[i][k] * matrix[j][k]).sum::<f64>();
            if i == j {
                if sum <= 1e-13 * largest {
                    return None;
                }
                matrix[i][i] = sum.sqrt();
            } else {
                matrix[i][j] = sum / matrix[j][j];
            }
        }
        right[i] = (right[i] - (0..i).map(|k| matrix[i][k] * right[k]).sum::<f64>()) / matrix[i][i];
    }
    for i in (0..6).rev() {
        right[i] = (right[i] - (i + 1..6).map(|k| matrix[k][i] * right[k]).sum::<f64>()) / matrix[i][i];
    }
    Some(right)
}

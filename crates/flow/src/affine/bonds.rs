//! The coupling of neighbouring patches, which is weaker where the flow is rough.
//!
//! The energy of a pair has two parts: the mismatch of the two affine predictions half-way, and the difference of the
//! two gradients. The energy is multiplied by the pair's *bond*, `1/(1 + q/t)`, where `q` is the roughness of the
//! current field at the pair. This is a robust prior of the Cauchy type: it does not smooth the rim of a press or a
//! motion boundary.

use super::grid::PatchGrid;
use super::nodes::Planes;
use crate::multiply_add::multiply_add;
use fearless_simd::Simd;
use fearless_simd_macros::simd;

/// Stiffness of the coupling between neighbours, per px².
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stiffness {
    /// `1/s_c²`: on the mismatch half-way.
    pub(crate) continuity: f32,
    /// `1/s_k²`: on the difference of the gradients, px per stride.
    pub(crate) curvature: f32,
    /// `t`, the roughness at which a bond is ½, dimensionless. Roughness is the energy of a pair with bond 1.
    pub(crate) tolerance: f32,
}

/// The bonds of all pairs of neighbours, and scratch memory.
#[derive(Debug, Clone)]
pub(crate) struct Bonds {
    grid: PatchGrid,
    stiffness: Stiffness,
    /// The bond of every node with its right neighbour, 0 to 1; the last one of a row is not used.
    right: Vec<f32>,
    /// The bond of every node with its lower neighbour, 0 to 1.
    below: Vec<f32>,
    /// Derivatives of the energy of the pairs in a row, by the mismatch, the x slope and the y slope. Along a row,
    /// entry `i` belongs to the pair `(i − 1, i)`; the first and the last stay zero.
    forces: [Vec<f32>; 3],
}

/// Value, x slope and y slope of one component along a row of nodes.
type Row<'a> = [&'a [f32]; 3];

impl Bonds {
    pub(crate) fn new(grid: PatchGrid, stiffness: Stiffness) -> Self {
        Self {
            grid,
            stiffness,
            right: vec![1.0; grid.nodes()],
            below: vec![1.0; grid.nodes()],
            forces: std::array::from_fn(|_| vec![0.0; grid.columns + 1]),
        }
    }

    /// The stiffness of a pair with bond 1.
    pub(crate) fn stiffness(&self) -> Stiffness {
        self.stiffness
    }

    /// Computes the bonds from the roughness of a field.
    #[simd]
    pub(crate) fn update<S: Simd>(&mut self, simd: S, field: &Planes) {
        let Self { grid, stiffness, right, below, .. } = self;
        let columns = grid.columns;
        for j in 0..grid.rows {
            let (start, end) = (j * columns, (j + 1) * columns);
            let across = &mut right[start..end - 1];
            across.fill(0.0);
            for component in [0, 3] {
                let near = row(field, component, start, columns - 1);
                let far = row(field, component, start + 1, columns - 1);
                add_roughness(simd, *stiffness, (near, far), 1, across);
            }
            to_bonds(stiffness.tolerance, across);
            if j + 1 < grid.rows {
                let down = &mut below[start..end];
                down.fill(0.0);
                for component in [0, 3] {
                    let near = row(field, component, start, columns);
                    let far = row(field, component, end, columns);
                    add_roughness(simd, *stiffness, (near, far), 2, down);
                }
                to_bonds(stiffness.tolerance, down);
            }
        }
    }

    /// Mean roughness of a node's pairs at the last update of the bonds, relative to what the prior expects.
    pub(crate) fn roughness(&self, node: usize) -> f32 {
        let columns = self.grid.columns;
        let bonds = [
            (!(node + 1).is_multiple_of(columns)).then(|| self.right[node]),
            (!node.is_multiple_of(columns)).then(|| self.right[node - 1]),
            (node + columns < self.grid.nodes()).then(|| self.below[node]),
            node.checked_sub(columns).map(|above| self.below[above]),
        ];
        let (mut sum, mut count) = (0.0, 0.0);
        for bond in bonds.into_iter().flatten() {
            sum += self.stiffness.tolerance * (1.0 / bond - 1.0);
            count += 1.0;
        }
        if count > 0.0 { sum / count } else { 0.0 }
    }

    /// Sums every node's bonds along its row and along its column.
    pub(crate) fn sum_into(&self, beside: &mut [f32], above: &mut [f32]) {
        let (columns, nodes) = (self.grid.columns, self.grid.nodes());
        beside[..nodes].fill(0.0);
        above[..nodes].fill(0.0);
        for start in (0..nodes).step_by(columns) {
            for i in start..start + columns - 1 {
                beside[i] += self.right[i];
                beside[i + 1] += self.right[i];
            }
        }
        for i in 0..nodes - columns {
            above[i] += self.below[i];
            above[i + columns] += self.below[i];
        }
    }

    /// `y += K x` with the stiffness matrix `K` of all pairs.
    #[simd]
    pub(crate) fn add_product<S: Simd>(&mut self, simd: S, x: &Planes, y: &mut Planes) {
        for component in [0, 3] {
            for j in 0..self.grid.rows {
                self.add_product_of_row(simd, component, j, x, y);
                if j + 1 < self.grid.rows {
                    self.add_product_with_row_below(simd, component, j, x, y);
                }
            }
        }
    }

    #[inline(always)]
    fn add_product_of_row<S: Simd>(&mut self, simd: S, component: usize, j: usize, x: &Planes, y: &mut Planes) {
        let columns = self.grid.columns;
        let start = j * columns;
        let near = row(x, component, start, columns - 1);
        let far = row(x, component, start + 1, columns - 1);
        let [mismatch, slope_x, slope_y] = &mut self.forces;
        let inner = [&mut mismatch[1..columns], &mut slope_x[1..columns], &mut slope_y[1..columns]];
        differentiate_energy(simd, self.stiffness, &self.right[start..][..columns - 1], (near, far), 1, inner);
        // The last node has no right neighbour.
        for force in &mut self.forces {
            force[columns] = 0.0;
        }
        let [value, along, beside] = rows_mut(y, component, start, columns);
        let left = self.forces.each_ref().map(|force| &force[..columns]);
        let right = self.forces.each_ref().map(|force| &force[1..=columns]);
        for i in 0..columns {
            value[i] += right[0][i] - left[0][i];
            along[i] = multiply_add(simd, 0.5, right[0][i] + left[0][i], along[i] + (right[1][i] - left[1][i]));
            beside[i] += right[2][i] - left[2][i];
        }
    }

    #[inline(always)]
    fn add_product_with_row_below<S: Simd>(&mut self, simd: S, component: usize, j: usize, x: &Planes, y: &mut Planes) {
        let columns = self.grid.columns;
        let start = j * columns;
        let near = row(x, component, start, columns);
        let far = row(x, component, start + columns, columns);
        let [mismatch, slope_x, slope_y] = self.forces.each_mut().map(|force| &mut force[1..=columns]);
        let inner = [&mut *mismatch, &mut *slope_x, &mut *slope_y];
        differentiate_energy(simd, self.stiffness, &self.below[start..][..columns], (near, far), 2, inner);
        for (first, sign) in [(start, 1.0), (start + columns, -1.0)] {
            let [value, beside, along] = rows_mut(y, component, first, columns);
            for i in 0..columns {
                value[i] = multiply_add(simd, sign, mismatch[i], value[i]);
                beside[i] = multiply_add(simd, sign, slope_x[i], beside[i]);
                along[i] = multiply_add(simd, 0.5, mismatch[i], multiply_add(simd, sign, slope_y[i], along[i]));
            }
        }
    }
}

#[inline(always)]
fn row(planes: &Planes, component: usize, start: usize, len: usize) -> Row<'_> {
    std::array::from_fn(|k| &planes[component + k][start..][..len])
}

#[inline(always)]
fn rows_mut(planes: &mut Planes, component: usize, start: usize, len: usize) -> [&mut [f32]; 3] {
    let rows: &mut [Vec<f32>; 3] = planes[component..].first_chunk_mut().expect("three planes of one component");
    rows.each_mut().map(|plane| &mut plane[start..][..len])
}

/// Adds the roughness of pairs, relative to what the prior expects. Row `along` of both has the slopes along the pair.
#[inline(always)]
fn add_roughness<S: Simd>(
    simd: S,
    stiffness: Stiffness,
    (near, far): (Row<'_>, Row<'_>),
    along: usize,
    roughness: &mut [f32],
) {
    // Slices of one known length let the loop run without bounds checks.
    let n = roughness.len();
    let (near, far) = (near.map(|row| &row[..n]), far.map(|row| &row[..n]));
    for i in 0..n {
        let mismatch = multiply_add(simd, 0.5, near[along][i] + far[along][i], near[0][i] - far[0][i]);
        let (dx, dy) = (near[1][i] - far[1][i], near[2][i] - far[2][i]);
        let bending = multiply_add(simd, dx, dx, dy * dy);
        let sum = multiply_add(simd, stiffness.curvature, bending, roughness[i]);
        roughness[i] = multiply_add(simd, stiffness.continuity * mismatch, mismatch, sum);
    }
}

/// Converts roughness to bonds.
#[inline(always)]
fn to_bonds(tolerance: f32, roughness: &mut [f32]) {
    for roughness in roughness {
        *roughness = tolerance / (tolerance + *roughness);
    }
}

/// Derivatives of the energy of pairs by the mismatch and by both slopes. Row `along` of both has the slopes along the pair.
#[inline(always)]
fn differentiate_energy<S: Simd>(
    simd: S,
    stiffness: Stiffness,
    bonds: &[f32],
    (near, far): (Row<'_>, Row<'_>),
    along: usize,
    [mismatch, slope_x, slope_y]: [&mut [f32]; 3],
) {
    let n = bonds.len();
    let (near, far) = (near.map(|row| &row[..n]), far.map(|row| &row[..n]));
    let (mismatch, slope_x, slope_y) = (&mut mismatch[..n], &mut slope_x[..n], &mut slope_y[..n]);
    for i in 0..n {
        let bending = bonds[i] * stiffness.curvature;
        let distance = multiply_add(simd, 0.5, near[along][i] + far[along][i], near[0][i] - far[0][i]);
        mismatch[i] = bonds[i] * stiffness.continuity * distance;
        slope_x[i] = bending * (near[1][i] - far[1][i]);
        slope_y[i] = bending * (near[2][i] - far[2][i]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    fn noise(seed: &mut u32) -> f32 {
        *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*seed >> 8) as f32 / 8_388_608.0 - 1.0
    }

    /// Energy of all bonds, from its definition.
    fn energy(bonds: &Bonds, x: &Planes) -> f64 {
        let columns = bonds.grid.columns;
        let mut sum = 0.0;
        for node in 0..bonds.grid.nodes() {
            let pairs = [
                ((node + 1) % columns != 0).then(|| (node + 1, 1, bonds.right[node])),
                (node + columns < bonds.grid.nodes()).then(|| (node + columns, 2, bonds.below[node])),
            ];
            for (other, slope, bond) in pairs.into_iter().flatten() {
                for c in [0, 3] {
                    let d = |k: usize| f64::from(x[c + k][node]) - f64::from(x[c + k][other]);
                    let ends = f64::from(x[c + slope][node]) + f64::from(x[c + slope][other]);
                    let mismatch = d(0) + 0.5 * ends;
                    let Stiffness { continuity, curvature, .. } = bonds.stiffness;
                    let bending = d(1) * d(1) + d(2) * d(2);
                    sum += f64::from(bond)
                        * (f64::from(continuity) * mismatch * mismatch + f64::from(curvature) * bending);
                }
            }
        }
        sum
    }

    #[test]
    fn the_product_is_half_the_gradient_of_the_energy() {
        let grid = PatchGrid::over(50, 37);
        let stiffness = Stiffness { continuity: 3.0, curvature: 2.0, tolerance: 4.0 };
        let mut bonds = Bonds::new(grid, stiffness);
        let mut seed = 7;
        let x: Planes = std::array::from_fn(|_| (0..grid.plane_len()).map(|_| noise(&mut seed)).collect());
        dispatch!(Level::new(), simd => bonds.update(simd, &x));
        let mut y: Planes = std::array::from_fn(|_| vec![0.0; grid.plane_len()]);
        dispatch!(Level::new(), simd => bonds.add_product(simd, &x, &mut y));
        // A quadratic form equals half its gradient times its argument.
        let product: f64 = x.iter().zip(&y).flat_map(|(x, y)| x.iter().zip(y)).map(|(x, y)| f64::from(x * y)).sum();
        let expected = energy(&bonds, &x);
        assert!((product - expected).abs() < 1e-4 * expected, "{product} against {expected}");
        for (plane, node) in [(0, 0), (1, 9), (2, 16), (3, 34), (4, 20), (5, 13)] {
            let mut shifted = x.clone();
            shifted[plane][node] += 0.5;
            let up = energy(&bonds, &shifted);
            shifted[plane][node] -= 1.0;
            let slope = 0.5 * (up - energy(&bonds, &shifted));
            let found = f64::from(y[plane][node]);
            assert!((found - slope).abs() < 1e-3, "plane {plane}, node {node}: {found} against {slope}");
        }
    }

    #[test]
    fn a_quadratic_field_has_no_mismatch() {
        let grid = PatchGrid::over(48, 40);
        let mut bonds = Bonds::new(grid, Stiffness { continuity: 1.0, curvature: 0.0, tolerance: 1e9 });
        let mut x: Planes = std::array::from_fn(|_| vec![0.0; grid.plane_len()]);
        for node in 0..grid.nodes() {
            let (i, j) = ((node % grid.columns) as f32, (node / grid.columns) as f32);
            x[0][node] = 0.3 * i * i - 0.2 * j * j;
            x[1][node] = 0.6 * i;
            x[2][node] = -0.4 * j;
        }
        let mut y: Planes = std::array::from_fn(|_| vec![0.0; grid.plane_len()]);
        dispatch!(Level::new(), simd => bonds.add_product(simd, &x, &mut y));
        assert!(y.iter().flatten().all(|force| force.abs() < 1e-5));
    }
}

//! One element: its energy, nodal forces and tangent stiffness.

use super::Material;
use super::volume::Volume;
use crate::Law;
use std::sync::LazyLock;

/// Corners of the cube `[−1, 1]³`: bit 0 of a node's number is x, bit 1 is y, bit 2 is z.
fn corner(node: usize) -> [f64; 3] {
    [0, 1, 2].map(|axis| if node >> axis & 1 == 1 { 1.0 } else { -1.0 })
}

/// Derivatives of the eight shape functions at the eight Gauss points, by the cube's coordinates.
static SHAPE_GRADIENTS: LazyLock<[[[f64; 3]; 8]; 8]> = LazyLock::new(|| {
    let gauss = 1.0 / 3.0_f64.sqrt();
    std::array::from_fn(|point| {
        let place = corner(point).map(|sign| gauss * sign);
        std::array::from_fn(|node| {
            let sign = corner(node);
            let factor = [0, 1, 2].map(|axis| 1.0 + sign[axis] * place[axis]);
            [
                0.125 * sign[0] * factor[1] * factor[2],
                0.125 * factor[0] * sign[1] * factor[2],
                0.125 * factor[0] * factor[1] * sign[2],
            ]
        })
    })
});

/// An element that is turned inside out: its energy is infinite.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Inverted;

/// A vector at each of an element's nodes.
pub(crate) type Nodes = [[f64; 3]; 8];

/// `[i][j][a][b]`: derivative of node `a`'s force along `i` by node `b`'s displacement along `j`.
pub(crate) type Stiffness = [[[[f64; 8]; 8]; 3]; 3];

/// An element at rest: its gradients and volumes, before any displacement.
pub(super) struct Geometry {
    /// Undeformed volume of each Gauss point, mm³.
    weights: [f64; 8],
    /// Gradient of each shape function at each Gauss point as `[point][axis][node]`, 1/mm.
    gradients: [[[f64; 8]; 3]; 8],
}

impl Geometry {
    /// # Errors
    ///
    /// [`Inverted`] if the nodes do not span a body.
    #[inline(always)]
    pub(super) fn new(nodes: &Nodes) -> Result<Self, Inverted> {
        let mut geometry = Self { weights: [0.0; 8], gradients: [[[0.0; 8]; 3]; 8] };
        for (point, shape) in SHAPE_GRADIENTS.iter().enumerate() {
            let mut jacobian = [[0.0; 3]; 3];
            for (node, gradient) in nodes.iter().zip(shape) {
                for (r, c) in (0..9).map(|n| (n / 3, n % 3)) {
                    jacobian[r][c] += node[r] * gradient[c];
                }
            }
            let (inverse_transpose, determinant) = inverse_transpose(&jacobian);
            if determinant <= 0.0 || !determinant.is_finite() {
                return Err(Inverted);
            }
            geometry.weights[point] = determinant;
            for (node, gradient) in shape.iter().enumerate() {
                for axis in 0..3 {
                    geometry.gradients[point][axis][node] = dot(&inverse_transpose[axis], gradient);
                }
            }
        }
        Ok(geometry)
    }
}

/// An element's state under a displacement.
pub(super) struct Element<'a> {
    geometry: &'a Geometry,
    material: &'a Material,
    points: [Point; 8],
    volume: Volume,
}

/// The deformation at a Gauss point.
#[derive(Clone, Copy, Default)]
struct Point {
    /// Deformation gradient F.
    gradient: [[f64; 3]; 3],
    /// Its inverse, transposed.
    inverse_transpose: [[f64; 3]; 3],
    /// Its determinant.
    volume_ratio: f64,
}

impl<'a> Element<'a> {
    /// # Errors
    ///
    /// [`Inverted`] if a point of the element has no volume left.
    #[inline(always)]
    pub(super) fn new(geometry: &'a Geometry, material: &'a Material, displacement: &Nodes) -> Result<Self, Inverted> {
        let mut points = [Point::default(); 8];
        for (point, shape) in points.iter_mut().zip(&geometry.gradients) {
            for (r, c) in (0..9).map(|n| (n / 3, n % 3)) {
                let change: f64 = displacement.iter().zip(&shape[c]).map(|(node, gradient)| node[r] * gradient).sum();
                point.gradient[r][c] = change + f64::from(u8::from(r == c));
            }
            (point.inverse_transpose, point.volume_ratio) = inverse_transpose(&point.gradient);
            if point.volume_ratio.is_nan() || point.volume_ratio <= 0.0 {
                return Err(Inverted);
            }
        }
        let ratios = points.each_ref().map(|point| point.volume_ratio);
        Ok(Self { geometry, material, volume: Volume::new(&geometry.weights, &ratios, material), points })
    }

    /// Strain energy, N mm.
    #[inline(always)]
    pub(super) fn energy(&self) -> f64 {
        let shear = self
            .points
            .iter()
            .zip(self.geometry.weights)
            .map(|(point, weight)| weight * (square_sum(&point.gradient) - 3.0 - 2.0 * point.volume_ratio.ln()));
        self.volume.energy + 0.5 * self.material.shear_modulus * shear.sum::<f64>()
    }

    /// Gradient of the energy: the external force on each node in this state, N.
    #[inline(always)]
    pub(super) fn forces(&self) -> Nodes {
        let pressure = self.volume.slope / self.volume.deformed;
        let mut forces = [[0.0; 3]; 8];
        for (index, point) in self.points.iter().enumerate() {
            let weight = self.geometry.weights[index];
            let mu = weight * self.material.shear_modulus;
            let normal = weight * (pressure * point.volume_ratio + self.volume.uneven[index][0]) - mu;
            // First Piola–Kirchhoff stress times the weight.
            let stress = [0, 1, 2]
                .map(|r| [0, 1, 2].map(|c| mu * point.gradient[r][c] + normal * point.inverse_transpose[r][c]));
            let shape = &self.geometry.gradients[index];
            for (node, force) in forces.iter_mut().enumerate() {
                for (axis, force) in force.iter_mut().enumerate() {
                    *force += (0..3).map(|c| stress[axis][c] * shape[c][node]).sum::<f64>();
                }
            }
        }
        forces
    }

    /// Second derivative of the energy, N/mm.
    #[inline(always)]
    pub(super) fn stiffness_into(&self, stiffness: &mut Stiffness) {
        *stiffness = [[[[0.0; 8]; 8]; 3]; 3];
        let Volume { slope, curvature, deformed, .. } = self.volume;
        // Derivatives by the displacements: of the logarithm of the mean volume ratio, and of the points' mean of φ'.
        let (mut mean, mut uneven) = ([[0.0; 8]; 3], [[0.0; 8]; 3]);
        for (index, point) in self.points.iter().enumerate() {
            let (weight, [first, second]) = (self.geometry.weights[index], self.volume.uneven[index]);
            let spatial = self.spatial_gradients(index);
            let share = weight * point.volume_ratio / deformed;
            for axis in 0..3 {
                for node in 0..8 {
                    mean[axis][node] += share * spatial[axis][node];
                    uneven[axis][node] += weight * second * spatial[axis][node];
                }
            }
            let (mu, held) = (weight * self.material.shear_modulus, slope * share);
            let (parallel, crossed) = (held + weight * second, mu - held - weight * first);
            add_stiffness(&self.geometry.gradients[index], &spatial, [mu, parallel, crossed], stiffness);
        }
        // Half of the square of the mean belongs to each of the two products.
        for (uneven, mean) in uneven.as_flattened_mut().iter_mut().zip(mean.as_flattened()) {
            *uneven = 0.5 * (curvature - slope) * mean - *uneven;
        }
        add_products(&mean, &uneven, stiffness);
        // The other half by symmetry.
        for (i, j) in [(1, 0), (2, 0), (2, 1)] {
            for (a, b) in (0..64).map(|n| (n / 8, n % 8)) {
                stiffness[i][j][a][b] = stiffness[j][i][b][a];
            }
        }
    }

    /// Gradients of the shape functions by the deformed place, `F⁻ᵀ ∇N`, as `[axis][node]`.
    #[inline(always)]
    fn spatial_gradients(&self, index: usize) -> [[f64; 8]; 3] {
        let (shape, matrix) = (&self.geometry.gradients[index], &self.points[index].inverse_transpose);
        [0, 1, 2].map(|r| std::array::from_fn(|node| (0..3).map(|c| matrix[r][c] * shape[c][node]).sum::<f64>()))
    }

    /// Small-strain stiffness and forces: the tangent at rest times the displacement.
    pub(super) fn linear(geometry: &Geometry, material: &Material, stiffness: &mut Stiffness) {
        let rest = Point { gradient: IDENTITY, inverse_transpose: IDENTITY, volume_ratio: 1.0 };
        let volume = Volume::new(&geometry.weights, &[1.0; 8], material);
        Element { geometry, material, points: [rest; 8], volume }.stiffness_into(stiffness);
    }
}

const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Adds `c₀ ∇N_a·∇N_b δ_ij + c₁ g_a,i g_b,j + c₂ g_a,j g_b,i` for `i ≤ j`, with `g` the spatial gradients.
#[inline(always)]
fn add_stiffness(
    shape: &[[f64; 8]; 3],
    spatial: &[[f64; 8]; 3],
    [along, parallel, crossed]: [f64; 3],
    stiffness: &mut Stiffness,
) {
    let (n, g) = (shape, spatial);
    for a in 0..8 {
        for (i, j) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
            let (by_parallel, by_crossed) = (parallel * g[i][a], crossed * g[j][a]);
            let target = &mut stiffness[i][j][a];
            for b in 0..8 {
                target[b] += by_parallel * g[j][b] + by_crossed * g[i][b];
            }
            if i == j {
                for b in 0..8 {
                    target[b] += along * (n[0][a] * n[0][b] + n[1][a] * n[1][b] + n[2][a] * n[2][b]);
                }
            }
        }
    }
}

/// Adds `p_a,i q_b,j + q_a,i p_b,j` for `i ≤ j`.
#[inline(always)]
fn add_products(p: &[[f64; 8]; 3], q: &[[f64; 8]; 3], stiffness: &mut Stiffness) {
    for (i, j, a) in (0..72).map(|n| (n / 24, n / 8 % 3, n % 8)).filter(|(i, j, _)| i <= j) {
        let (by_q, by_p) = (p[i][a], q[i][a]);
        for ((value, p), q) in stiffness[i][j][a].iter_mut().zip(&p[j]).zip(&q[j]) {
            *value += by_q * q + by_p * p;
        }
    }
}

/// Energy and forces of an element.
///
/// # Errors
///
/// [`Inverted`] if the element has no volume left somewhere.
#[inline(always)]
pub(super) fn evaluate(nodes: &Nodes, displacement: &Nodes, material: &Material) -> Result<(f64, Nodes), Inverted> {
    let geometry = Geometry::new(nodes)?;
    if material.law == Law::Linear {
        let mut stiffness = [[[[0.0; 8]; 8]; 3]; 3];
        Element::linear(&geometry, material, &mut stiffness);
        let force = |node: usize, axis: usize| {
            let columns = (0..24).map(|n| stiffness[axis][n / 8][node][n % 8] * displacement[n % 8][n / 8]);
            columns.sum::<f64>()
        };
        let forces: Nodes = std::array::from_fn(|node| [0, 1, 2].map(|axis| force(node, axis)));
        let work: f64 = forces.as_flattened().iter().zip(displacement.as_flattened()).map(|(f, u)| f * u).sum();
        return Ok((0.5 * work, forces));
    }
    let element = Element::new(&geometry, material, displacement)?;
    Ok((element.energy(), element.forces()))
}

/// Stiffness of an element.
///
/// # Errors
///
/// [`Inverted`] if the element has no volume left somewhere.
#[inline(always)]
pub(crate) fn stiffness(
    nodes: &Nodes,
    displacement: &Nodes,
    material: &Material,
    stiffness: &mut Stiffness,
) -> Result<(), Inverted> {
    let geometry = Geometry::new(nodes)?;
    match material.law {
        Law::Linear => Element::linear(&geometry, material, stiffness),
        Law::NeoHookean => Element::new(&geometry, material, displacement)?.stiffness_into(stiffness),
    }
    Ok(())
}

#[inline(always)]
fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn square_sum(matrix: &[[f64; 3]; 3]) -> f64 {
    matrix.iter().flatten().map(|value| value * value).sum()
}

/// Inverse transpose and determinant.
#[inline(always)]
fn inverse_transpose(a: &[[f64; 3]; 3]) -> ([[f64; 3]; 3], f64) {
    let cofactor = [0, 1, 2].map(|r| {
        [0, 1, 2].map(|c| {
            let (r1, r2, c1, c2) = ((r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3);
            a[r1][c1] * a[r2][c2] - a[r1][c2] * a[r2][c1]
        })
    });
    let determinant = dot(&a[0], &cofactor[0]);
    (cofactor.map(|row| row.map(|value| value / determinant)), determinant)
}

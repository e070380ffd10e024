//! The coarse mesh extended to infinity: displacement at one node of its surface caused by a force at another.
//!
//! A wave of nodal displacements `u_level e^{i θ·place}`, with `place` counted in elements, meets nodal forces
//! `Σ K e^{i θ·(place_b − place_a)} u`: 3×3 matrices between neighbouring levels of nodes. In a mesh with mirror planes
//! their entries between horizontal and vertical are imaginary and all others real, so with `i w` in place of the
//! vertical component the system is real. Levels are eliminated from the base up; the matrix that remains at the
//! surface is the stiffness of the wave. A sum over all waves of a long period brings its inverse back to space.

use std::f64::consts::TAU;

use super::mesh::CoarseMesh;
use super::near::Near;
use crate::layer::Layer;
use crate::layer::half_space::Influence;
use crate::layer::operator::influence_of;

/// The period is longer than the block by this many thicknesses: the nearest image has no effect.
const PERIOD: f64 = 9.0;

type Matrix = [[f64; 3]; 3];

/// Displacement at a node of the surface by unit force at another, times the shear modulus, 1/mm.
pub(super) struct EndlessMesh {
    columns: usize,
    table: Vec<Influence>,
}

impl EndlessMesh {
    /// For offsets within the block.
    pub(super) fn new(mesh: &CoarseMesh) -> Self {
        let [columns, rows] = mesh.nodes();
        let thickness_mm = mesh.cell_mm[2] * mesh.cells[2] as f64;
        let axes = [0, 1].map(|axis| {
            let nodes = mesh.nodes()[axis];
            Axis::new(nodes, nodes + (PERIOD * thickness_mm / mesh.cell_mm[axis]).ceil() as usize)
        });
        // Along x first: for each wave along y, each offset along x.
        let mut table = vec![Influence::default(); columns * rows];
        for (wave_y, theta_y) in axes[1].angles.iter().enumerate() {
            let mut along_x = vec![Influence::default(); columns];
            for (wave_x, theta_x) in axes[0].angles.iter().enumerate() {
                let compliance = compliance(mesh, [*theta_x, *theta_y]);
                for (offset, sum) in along_x.iter_mut().enumerate() {
                    let (cos, sin) = axes[0].wave(wave_x, offset);
                    add(sum, &compliance, [cos, sin, cos, sin, cos, cos]);
                }
            }
            for (index, sum) in table.iter_mut().enumerate() {
                let (cos, sin) = axes[1].wave(wave_y, index / columns);
                add(sum, &along_x[index % columns], [cos, sin, cos, cos, sin, cos]);
            }
        }
        Self { columns, table }
    }

    /// Subtracts the near part of a layer's influence, so that the rest is the part for the coarse nodes.
    pub(super) fn leave_far(&mut self, mesh: &CoarseMesh, layer: &Layer, near: Near) {
        let [dx, dy, _] = mesh.cell_mm;
        // Practically a point, and no offset is on the prolongation of its sides.
        let point_mm = 0.1 * dx.min(dy);
        let [width, height] = [0, 1].map(|axis| mesh.cell_mm[axis] * mesh.cells[axis] as f64);
        let influence = influence_of(layer, point_mm, width.hypot(height));
        for (index, entry) in self.table.iter_mut().enumerate() {
            let offset = [(index % self.columns) as f64 * dx, (index / self.columns) as f64 * dy];
            let far = (1.0 - near.share(offset)) / (point_mm * point_mm);
            *entry = entry.plus(influence(offset).times(-far));
        }
    }

    /// Displacement along `axes[0]` by force along `axes[1]`, at an offset in elements.
    pub(super) fn at(&self, offset: [isize; 2], axes: [usize; 2]) -> f64 {
        let [x, y] = offset.map(isize::unsigned_abs);
        let influence = &self.table[y * self.columns + x];
        let sign = |axis: usize| if offset[axis] < 0 { -1.0 } else { 1.0 };
        match axes {
            [0, 0] => influence.xx,
            [1, 1] => influence.yy,
            [2, 2] => influence.zz,
            [0, 1] | [1, 0] => sign(0) * sign(1) * influence.xy,
            [0, 2] => sign(0) * influence.xz,
            [2, 0] => -sign(0) * influence.xz,
            [1, 2] => sign(1) * influence.yz,
            _ => -sign(1) * influence.yz,
        }
    }
}

/// Waves of a period and their values at offsets; a wave and its reverse are one.
struct Axis {
    angles: Vec<f64>,
    /// Cosine and sine by wave and offset, times the wave's weight.
    values: Vec<(f64, f64)>,
    offsets: usize,
}

impl Axis {
    fn new(offsets: usize, period: usize) -> Self {
        let angle = |wave: usize| TAU * wave as f64 / period as f64;
        let waves = 0..=period / 2;
        let values = waves.clone().flat_map(|wave| {
            let weight = if wave == 0 || 2 * wave == period { 1.0 } else { 2.0 } / period as f64;
            (0..offsets).map(move |offset| {
                let (sin, cos) = (angle(1) * (wave * offset % period) as f64).sin_cos();
                (weight * cos, weight * sin)
            })
        });
        Self { angles: waves.map(angle).collect(), values: values.collect(), offsets }
    }

    fn wave(&self, wave: usize, offset: usize) -> (f64, f64) {
        self.values[wave * self.offsets + offset]
    }
}

/// Adds `part` entry by entry, each times its factor, in the order xx, xy, yy, xz, yz, zz.
fn add(sum: &mut Influence, part: &Influence, [xx, xy, yy, xz, yz, zz]: [f64; 6]) {
    *sum = sum.plus(Influence {
        xx: xx * part.xx,
        xy: xy * part.xy,
        yy: yy * part.yy,
        xz: xz * part.xz,
        yz: yz * part.yz,
        zz: zz * part.zz,
    });
}

/// Compliance of the surface to a wave, such that entries times cosines (sines along the axes in which an entry is odd)
/// give displacement in space.
fn compliance(mesh: &CoarseMesh, theta: [f64; 2]) -> Influence {
    let [above, coupling, below] = levels(mesh, theta);
    let inner = sum(&above, &below);
    let mut rest = inner;
    for _ in 2..mesh.cells[2] {
        rest = minus(&inner, &condensed(&coupling, &rest));
    }
    let surface = inverse(&minus(&above, &condensed(&coupling, &rest)));
    // Odd along both axes: (i sin)² = −sin². To the vertical from w: −i times i sin.
    Influence {
        xx: surface[0][0],
        xy: -surface[0][1],
        yy: surface[1][1],
        xz: surface[0][2],
        yz: surface[1][2],
        zz: surface[2][2],
    }
}

/// Matrices of a layer of elements: within its upper level of nodes, from its lower to its upper, within its lower.
fn levels(mesh: &CoarseMesh, theta: [f64; 2]) -> [Matrix; 3] {
    let mut levels = [[[0.0; 3]; 3]; 3];
    let pairs = (0..4).flat_map(|a| (0..4).map(move |b| (a, b)));
    for (a, b) in pairs {
        let step = |axis: usize| f64::from((b >> axis & 1) - (a >> axis & 1));
        let (sin, cos) = (theta[0] * step(0) + theta[1] * step(1)).sin_cos();
        for (level, (above, below)) in levels.iter_mut().zip([(0, 0), (0, 4), (4, 4)]) {
            let [a, b] = [a as usize + above, b as usize + below];
            for (r, c) in (0..9).map(|n| (n / 3, n % 3)) {
                let factor = match (r, c) {
                    (0 | 1, 2) => -sin,
                    (2, 0 | 1) => sin,
                    _ => cos,
                };
                level[r][c] += factor * mesh.element[r][c][a][b];
            }
        }
    }
    levels
}

/// `U S⁻¹ Uᵀ`.
fn condensed(coupling: &Matrix, rest: &Matrix) -> Matrix {
    let inverse = inverse(rest);
    let half = [0, 1, 2].map(|r| [0, 1, 2].map(|c| (0..3).map(|n| coupling[r][n] * inverse[n][c]).sum::<f64>()));
    [0, 1, 2].map(|r| [0, 1, 2].map(|c| (0..3).map(|n| half[r][n] * coupling[c][n]).sum()))
}

fn sum(a: &Matrix, b: &Matrix) -> Matrix {
    [0, 1, 2].map(|r| [0, 1, 2].map(|c| a[r][c] + b[r][c]))
}

fn minus(a: &Matrix, b: &Matrix) -> Matrix {
    [0, 1, 2].map(|r| [0, 1, 2].map(|c| a[r][c] - b[r][c]))
}

fn inverse(a: &Matrix) -> Matrix {
    let cofactor = |r: usize, c: usize| {
        let (r1, r2, c1, c2) = ((r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3);
        a[r1][c1] * a[r2][c2] - a[r1][c2] * a[r2][c1]
    };
    let determinant: f64 = (0..3).map(|c| a[0][c] * cofactor(0, c)).sum();
    [0, 1, 2].map(|r| [0, 1, 2].map(|c| cofactor(c, r) / determinant))
}

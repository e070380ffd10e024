//! A second solution of the flat circular punch, with functions that contain the singularity of the tractions at the
//! edge.
//!
//! Pressure and radial shear have the Hankel transforms `P(k) = Σ a_m j_m(k)`, m even, and `T(k) = Σ b_m j_m(k)`, m
//! odd, with k in units of 1/radius and j the spherical Bessel functions: each is the transform of a function that
//! vanishes outside the circle and grows like the inverse root of the distance to its edge. The minimum of the energy
//! for a given depth is `A (a, b) = depth · (1, 0, …)`, `A = ∫ (N, −C; −C, L) j_m j_n dk`. The half-space's part is
//! `∫ j_m j_n dk = sin(π (m − n) / 2) / ((m − n) (m + n + 1))`, the remainder falls exponentially.

use super::super::Layer;
use super::super::compliance::Reduced;
use super::{assert_near, block, half_space, layer};

/// Normal force, N, of a rigid flat circular punch for each mm of depth.
pub(super) fn force_per_depth(layer: &Layer, radius_mm: f64, is_stuck: bool, functions: usize) -> f64 {
    let orders: Vec<usize> = (0..functions).map(|index| if is_stuck { index } else { 2 * index }).collect();
    let points = remainder(layer, radius_mm, orders.last().unwrap() + 1);
    let deep = Reduced::half_space(layer.poissons_ratio());
    let matrix = orders.iter().map(|&m| {
        let entry = |&n: &usize| {
            let near: f64 = points.iter().map(|(part, bessel)| of(part, m, n) * bessel[m] * bessel[n]).sum();
            of(&deep, m, n) * half_space_integral(m, n) + near
        };
        orders.iter().map(entry).collect()
    });
    let mut depth = vec![0.0; functions];
    depth[0] = 1.0;
    let coefficients = solve(matrix.collect(), depth);
    std::f64::consts::TAU * radius_mm * layer.shear_modulus_mpa() * coefficients[0]
}

/// The compliance between two functions: even ones press, odd ones shear.
fn of(part: &Reduced, m: usize, n: usize) -> f64 {
    match (m % 2, n % 2) {
        (0, 0) => part.normal,
        (1, 1) => part.longitudinal,
        _ => -part.coupling,
    }
}

fn half_space_integral(m: usize, n: usize) -> f64 {
    let (sum, difference) = ((m + n + 1) as f64, m as f64 - n as f64);
    let half = std::f64::consts::FRAC_PI_2;
    if m == n { half / sum } else { (half * difference).sin() / (difference * sum) }
}

/// The reduction of the compliance by the bonded base, times its weight, and the Bessel functions, at the points of a
/// quadrature by Simpson's rule.
fn remainder(layer: &Layer, radius_mm: f64, orders: usize) -> Vec<(Reduced, Vec<f64>)> {
    if layer.thickness_mm().is_infinite() {
        return Vec::new();
    }
    let (nu, ratio) = (layer.poissons_ratio(), layer.thickness_mm() / radius_mm);
    let deep = Reduced::half_space(nu);
    let (intervals, last) = (4000, 20.0 / ratio);
    let step = last / f64::from(intervals);
    let at = |index: i32| {
        let k = f64::from(index) * step;
        let simpson = if index == 0 || index == intervals { 1.0 } else { f64::from(2 + 2 * (index % 2)) };
        let (weight, near) = (simpson * step / 3.0, Reduced::at(k * ratio, nu));
        let part = Reduced {
            longitudinal: weight * (near.longitudinal - deep.longitudinal),
            transverse: 0.0,
            normal: weight * (near.normal - deep.normal),
            coupling: weight * (near.coupling - deep.coupling),
        };
        (part, spherical_bessel(k, orders))
    };
    (0..=intervals).map(at).collect()
}

/// `j_0 … j_{orders − 1}` by Miller's downward recurrence.
fn spherical_bessel(x: f64, orders: usize) -> Vec<f64> {
    let mut values = vec![0.0; orders];
    if x == 0.0 {
        values[0] = 1.0;
        return values;
    }
    let start = orders + 30 + 2 * x as usize;
    let (mut above, mut here) = (0.0, 1e-30);
    let mut sum = 0.0;
    for order in (0..start).rev() {
        let below = (2.0 * order as f64 + 3.0) / x * here - above;
        (above, here) = (here, below);
        if order < orders {
            values[order] = here;
        }
        sum += (2.0 * order as f64 + 1.0) * here * here;
        if here.abs() > 1e100 {
            (above, here, sum) = (above * 1e-100, here * 1e-100, sum * 1e-200);
            for value in &mut values {
                *value *= 1e-100;
            }
        }
    }
    // Σ (2n + 1) j_n² = 1; the sign is that of j_0 or j_1.
    let sign = if x.sin().abs() > 0.1 { x.sin() * values[0] } else { (x.sin() / x - x.cos()) * values[1] };
    let norm = sum.sqrt() * sign.signum();
    values.into_iter().map(|value| value / norm).collect()
}

/// Solves a symmetric positive definite system by elimination.
fn solve(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Vec<f64> {
    let size = right.len();
    for pivot in 0..size {
        for row in pivot + 1..size {
            let factor = matrix[row][pivot] / matrix[pivot][pivot];
            for column in pivot..size {
                matrix[row][column] -= factor * matrix[pivot][column];
            }
            right[row] -= factor * right[pivot];
        }
    }
    for row in (0..size).rev() {
        let known: f64 = (row + 1..size).map(|column| matrix[row][column] * right[column]).sum();
        right[row] = (right[row] - known) / matrix[row][row];
    }
    right
}

#[test]
fn on_a_half_space_it_is_the_classical_solution() {
    for nu in [0.0, 0.35, 0.48, 0.499] {
        let half_space = half_space(nu);
        let mu = half_space.shear_modulus_mpa();
        // Boussinesq (Johnson §3.4) without friction; Mossakovskii (1954) with the gel stuck.
        let free = 4.0 * mu * 4.0 / (1.0 - nu);
        let stuck = 4.0 * mu * 4.0 * (3.0 - 4.0 * nu).ln() / (1.0 - 2.0 * nu);
        assert_near(force_per_depth(&half_space, 4.0, false, 4), free, 1e-12, "free");
        assert_near(force_per_depth(&half_space, 4.0, true, 60), stuck, 1e-4, "stuck");
    }
}

#[test]
fn on_a_layer_more_functions_change_nothing() {
    for nu in [0.0, 0.35, 0.48] {
        let layer = layer(nu);
        let free = [8, 16].map(|functions| force_per_depth(&layer, 4.0, false, functions));
        let stuck = [40, 60].map(|functions| force_per_depth(&layer, 4.0, true, functions));
        assert_near(free[0], free[1], 1e-12, "free");
        assert_near(stuck[0], stuck[1], 1e-4, "stuck");
    }
    // On a thin layer the force goes to that of uniform compression, π a² (λ + 2μ) / h.
    let mut thin = block(0.35);
    thin.thickness_mm = 0.1;
    let thin = Layer::new(&thin).unwrap();
    let modulus = 0.6 * 0.65 / (1.35 * 0.3);
    let uniform = std::f64::consts::PI * 16.0 * modulus / 0.1;
    let force = force_per_depth(&thin, 4.0, false, 40);
    assert!((1.0..1.05).contains(&(force / uniform)), "{force} against {uniform}");
}

//! Young's modulus from known forces: in linear elasticity the force is proportional to it.

use super::fit::Settled;
use super::look::Look;

/// Force by elasticity against measured force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Modulus {
    pub(super) youngs_modulus_mpa: f64,
    /// Relative deviation from the scatter of the forces and the uncertainty of the gel.
    pub(super) deviation: f64,
}

/// Mismatch of depth at which a frame counts half.
const HALF: f64 = 0.1;

/// `E = Σ w F f / Σ w f²`, with f the force over the modulus by elasticity, and a smaller w where contact was found at
/// another depth than the known one; none without forces.
///
/// Its deviation has two parts: the scatter of the frames, and the effect on f of Poisson's ratio and thickness with this
/// covariance.
pub(super) fn modulus(looks: &[Look], settled: &Settled, covariance: [[f64; 2]; 2]) -> Option<Modulus> {
    let pairs: Vec<(usize, f64, f64, [f64; 2])> = looks
        .iter()
        .zip(settled.explained.iter().zip(&settled.force_slopes))
        .filter_map(|(look, (made, slope))| {
            let root = 1.0 / 1.0_f64.hypot(look.mismatch() / HALF);
            let [force, made] = [look.force_n?, made.force_per_modulus_mm2].map(|value| root * value);
            Some((look.press, force, made, slope.map(|slope| root * slope)))
        })
        .collect();
    let square: f64 = pairs.iter().map(|(_, _, made, _)| made * made).sum();
    if square <= 0.0 {
        return None;
    }
    let youngs_modulus_mpa = pairs.iter().map(|(_, force, made, _)| force * made).sum::<f64>() / square;
    // Frames of one press have similar errors.
    let presses = pairs.iter().map(|(press, ..)| press + 1).max().unwrap_or(0);
    let mut clusters = vec![0.0; presses];
    for (press, force, made, _) in &pairs {
        clusters[*press] += made * (force - youngs_modulus_mpa * made);
    }
    let used = clusters.iter().filter(|cluster| **cluster != 0.0).count().max(1) as f64;
    let scatter: f64 =
        clusters.iter().map(|cluster| cluster * cluster).sum::<f64>() / (square * youngs_modulus_mpa).powi(2);
    let scatter = scatter * used / (used - 1.0).max(1.0);
    // The relative change of E with ν and ln thickness is minus that of f.
    let slope = [0, 1].map(|i| pairs.iter().map(|(_, _, made, slope)| made * slope[i]).sum::<f64>() / square);
    let by_gel: f64 =
        (0..2).flat_map(|i| (0..2).map(move |j| (i, j))).map(|(i, j)| slope[i] * covariance[i][j] * slope[j]).sum();
    Some(Modulus { youngs_modulus_mpa, deviation: (scatter + by_gel.max(0.0)).sqrt() })
}

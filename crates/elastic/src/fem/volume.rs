//! The volumetric energy of an element.

use super::Material;

/// Energy of an element's volume and its derivatives: `V λ/2 L² + Σ w φ(ln J − L)`, with `L = ln J̄` the logarithm of the
/// mean volume ratio, `w` the undeformed volume of a Gauss point and `φ` the energy of an uneven volume there.
pub(super) struct Volume {
    /// Energy, N mm.
    pub(super) energy: f64,
    /// Derivative by `L`, N mm.
    pub(super) slope: f64,
    /// Second derivative by `L`, N mm.
    pub(super) curvature: f64,
    /// Deformed volume, mm³.
    pub(super) deformed: f64,
    /// First two derivatives of `φ` at each point, `MPa`.
    pub(super) uneven: [[f64; 2]; 8],
}

impl Volume {
    /// From each Gauss point's undeformed volume, mm³, and volume ratio.
    #[inline(always)]
    pub(super) fn new(weights: &[f64; 8], ratios: &[f64; 8], material: &Material) -> Self {
        let volume: f64 = weights.iter().sum();
        let deformed: f64 = weights.iter().zip(ratios).map(|(weight, ratio)| weight * ratio).sum();
        let (log, stiffness) = ((deformed / volume).ln(), volume * material.lame);
        let (mut energy, mut slope, mut curvature) = (0.5 * stiffness * log * log, stiffness * log, stiffness);
        let mut uneven = [[0.0; 2]; 8];
        for ((uneven, weight), ratio) in uneven.iter_mut().zip(weights).zip(ratios) {
            let [value, first, second] = material.uneven(ratio.ln() - log);
            energy += weight * value;
            slope -= weight * first;
            curvature += weight * second;
            *uneven = [first, second];
        }
        Self { energy, slope, curvature, deformed, uneven }
    }
}

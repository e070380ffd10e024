//! The gel's material.

use crate::{GelBlock, Law};

/// Elastic constants and the law that uses them.
///
/// Compressible neo-Hookean energy per undeformed volume ([Bonet2008] eq. (6.27)), its volumetric part with the
/// element's mean volume ratio `J̄`: `ψ = μ/2 (tr FᵀF − 3 − 2 ln J) + λ/2 ln² J̄`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Material {
    pub(crate) law: Law,
    /// Shear modulus μ, `MPa`.
    pub(crate) shear_modulus: f64,
    /// Lamé's first constant λ, `MPa`.
    pub(crate) lame: f64,
}

impl Material {
    /// From Young's modulus, `MPa`, and Poisson's ratio.
    pub(crate) fn new(law: Law, youngs_modulus: f64, poissons_ratio: f64) -> Self {
        Self {
            law,
            shear_modulus: youngs_modulus / (2.0 * (1.0 + poissons_ratio)),
            lame: youngs_modulus * poissons_ratio / ((1.0 + poissons_ratio) * (1.0 - 2.0 * poissons_ratio)),
        }
    }

    /// A block's material; one of 1 `MPa` where the modulus is unknown.
    pub(crate) fn of(block: &GelBlock, law: Law) -> Self {
        Self::new(law, block.youngs_modulus_mpa.unwrap_or(1.0), block.poissons_ratio)
    }

    /// Volumetric energy per volume, its derivative by the volume ratio and its second derivative, `MPa`.
    pub(crate) fn volumetric(&self, volume_ratio: f64) -> [f64; 3] {
        let (lambda, log) = (self.lame, volume_ratio.ln());
        let pressure = lambda * log / volume_ratio;
        [0.5 * lambda * log * log, pressure, (lambda / volume_ratio - pressure) / volume_ratio]
    }
}

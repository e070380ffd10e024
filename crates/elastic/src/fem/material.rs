//! The gel's material.

use crate::{GelBlock, Law};

/// Energy of an uneven volume within an element, over the shear modulus, dimensionless.
///
/// Enough to keep a square's face smooth: without friction, 6 mm wide and 3 mm deep, ν 0.35 and 0.48, cells of 0.75 and
/// 0.5 mm. It adds 0.1 % at a depth of 1 mm and 0.8 % at 2 mm to the force on such a square that sticks, with cells of 0.3 mm.
const UNEVENNESS: f64 = 6.0;

/// Elastic constants and the law that uses them.
///
/// Compressible neo-Hookean energy per undeformed volume ([Bonet2008] eq. (6.27)), its volumetric part with the element's
/// mean volume ratio `J̄`: `ψ = μ/2 (tr FᵀF − 3 − 2 ln J) + λ/2 ln² J̄ + 6 μ ln⁴(J / J̄)`. The last term belongs to the
/// elements, not to the gel; see the documentation of the folder.
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

    /// Energy per volume of a point whose volume ratio differs from its element's mean by `difference` in the logarithm, and
    /// its first two derivatives, `MPa`.
    #[inline(always)]
    pub(crate) fn uneven(&self, difference: f64) -> [f64; 3] {
        let modulus = UNEVENNESS * self.shear_modulus;
        let square = difference * difference;
        [modulus * square * square, 4.0 * modulus * square * difference, 12.0 * modulus * square]
    }
}

//! The normal force by the motion of the gel far from contact.
//!
//! Far from contact the gel moves in proportion to the force, whatever the shape of contact [Johnson1985]. In nearly
//! incompressible gel this motion is large, because gel that is pushed down has to move aside: it shows the force even where
//! contact is so shallow, or dragged so far, that depth is uncertain. Nearer to contact, and in compressible gel, the
//! strain and the perspective of the camera hide it.
//!
//! The tractions in contact cause a motion `c N + s S`: N by those along the normal, S by those along the surface. The measured
//! motion b gives c and s by least squares, where s is assumed to be 1 ± 0.1 and the model to be right to 3 % of N. At finite
//! strain the force is c times what is computed from depth, and a further factor `exp(0.28 d / a − 0.22 D)`, with the
//! narrowness d / a and the drag D of contact ([`super::stiffening`]). These two numbers were fitted to 90 frames of presses of
//! the simulator at ν 0.44 to 0.5, left out in turn: the factor is right to 2.4 % in contact with d / a below 0.2, where the
//! force from depth alone is right to 6.7 %; it is worse in narrow contact.
//!
//! The force is the mean of the two on a logarithmic scale, weighted by their variances.

#[cfg(test)]
mod tests;

use super::stiffening::Strain;
use super::surface::Seen;

/// Least Poisson's ratio: in gel that can be compressed more, the motion far from contact says little.
const LEAST_POISSONS_RATIO: f64 = 0.45;
/// Squares of the error of the model relative to N, over that of s before it is known.
const STIFFNESS_OF_SHEAR: f64 = 0.03 * 0.03 / (0.1 * 0.1);
/// Exponents of the factor for finite strain.
const BY_NARROWNESS: f64 = 0.28;
const BY_DRAG: f64 = -0.22;
/// Largest narrowness and drag among the presses that they were fitted to.
const MOST_NARROWNESS: f64 = 0.6;
const MOST_DRAG: f64 = 1.7;
/// Relative error of the force by the far field: of the model; of a Poisson's ratio that is known to ± 0.007; by narrowness; and
/// by the mean depth relative to the thickness.
const MODEL_ERROR: f64 = 0.025;
const GEL_ERROR: f64 = 0.035;
const ERROR_BY_NARROWNESS: f64 = 0.14;
const ERROR_BY_DEPTH: f64 = 0.6;
/// The part of the flow's error that is the same everywhere.
const COMMON_ERROR: f64 = 0.2;
/// Least number of cells.
const LEAST_CELLS: f64 = 100.0;
/// Largest correction, either way.
const MOST: f64 = 1.5;

/// Sums over the cells far from contact.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct FarField {
    count: f64,
    normal_square: f64,
    shear_square: f64,
    product: f64,
    by_normal: f64,
    by_shear: f64,
}

impl FarField {
    /// Whether the motion of gel with this Poisson's ratio far from contact shows the force.
    pub(super) fn is_telling(poissons_ratio: f64) -> bool {
        poissons_ratio >= LEAST_POISSONS_RATIO
    }

    /// Adds a cell: its measurement, its displacement by all tractions and by those along the normal, mm.
    pub(super) fn add(&mut self, seen: &Seen, moved_mm: [f32; 3], by_normal_mm: [f32; 3]) {
        self.count += 1.0;
        for axis in 0..2 {
            let apparent = |moved: [f32; 3]| f64::from(moved[axis] + seen.slope[axis] * moved[2]);
            let normal = apparent(by_normal_mm);
            let shear = apparent(moved_mm) - normal;
            let measured = f64::from(seen.apparent_mm[axis]);
            self.normal_square += normal * normal;
            self.shear_square += shear * shear;
            self.product += normal * shear;
            self.by_normal += normal * measured;
            self.by_shear += shear * measured;
        }
    }

    /// The factor from the normal force by depth, whose relative deviation is known, to that by both; `noise_mm` is the error
    /// of the flow that is allowed for a stuck face. 1 where the motion says nothing.
    pub(super) fn correction(&self, strain: Strain, deviation: f64, noise_mm: f64) -> f64 {
        let by_prior = STIFFNESS_OF_SHEAR * self.normal_square;
        let shear_square = self.shear_square + by_prior;
        let determinant = self.normal_square * shear_square - self.product.powi(2);
        let scale = (self.by_normal * shear_square - self.product * (self.by_shear + by_prior)) / determinant;
        let by_strain = BY_NARROWNESS * strain.narrowness.min(MOST_NARROWNESS) + BY_DRAG * strain.drag.min(MOST_DRAG);
        let wanted = scale.ln() + by_strain;
        let typical_mm = (self.normal_square / self.count).sqrt();
        let by_depth = ERROR_BY_DEPTH * (strain.narrowness * strain.confinement).sqrt();
        let by_narrowness = ERROR_BY_NARROWNESS * strain.narrowness;
        let errors = [MODEL_ERROR, GEL_ERROR, by_narrowness, by_depth, COMMON_ERROR * noise_mm / typical_mm];
        let variance: f64 = errors.iter().map(|error| error * error).sum();
        let share = deviation.powi(2) / (deviation.powi(2) + variance);
        let factor = (share * wanted).exp();
        // Also where nothing moves and the factor is not a number.
        let is_known = self.count >= LEAST_CELLS && factor.is_finite();
        if is_known { factor.clamp(1.0 / MOST, MOST) } else { 1.0 }
    }
}

//! The gel: size and material.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A block of gel, bonded at its base, with free sides.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GelBlock {
    /// Extent along x and y, mm.
    pub size_mm: [f64; 2],
    /// Distance from the surface to the rigid base, mm.
    pub thickness_mm: f64,
    /// Poisson's ratio, dimensionless: 0 is cork, just below 0.5 is rubber.
    pub poissons_ratio: f64,
    /// Young's modulus, `MPa`; without it there is no force.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub youngs_modulus_mpa: Option<f64>,
}

/// The relation between stress and strain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Law {
    /// Small strain: stress is proportional to it.
    Linear,
    /// Finite strain: the compressible neo-Hookean solid.
    #[default]
    NeoHookean,
}

/// An impossible block.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{key} is {value}: {allowed} is allowed")]
pub struct BlockError {
    /// Which value, by its name in the file.
    pub key: &'static str,
    /// The value.
    pub value: f64,
    /// The possible values.
    pub allowed: &'static str,
}

/// Thickness over the longer side beyond which the base has no effect: a thicker gel is assumed to be in another unit.
const MOST_THICKNESS: f64 = 4.0;
/// Largest Young's modulus, `MPa`: with a stiffer material no camera sees a deformation.
const MOST_STIFFNESS_MPA: f64 = 1e4;

impl GelBlock {
    /// Checks that every value is possible.
    ///
    /// # Errors
    ///
    /// [`BlockError`] naming the first value that is not.
    pub fn validate(&self) -> Result<(), BlockError> {
        let length = "a finite length above 0 mm";
        let is_positive = |value: f64| value.is_finite() && value > 0.0;
        let most_mm = MOST_THICKNESS * self.size_mm[0].max(self.size_mm[1]);
        let checks = [
            ("size_mm", self.size_mm[0], is_positive(self.size_mm[0]), length),
            ("size_mm", self.size_mm[1], is_positive(self.size_mm[1]), length),
            ("thickness_mm", self.thickness_mm, is_positive(self.thickness_mm), length),
            (
                "thickness_mm",
                self.thickness_mm,
                self.thickness_mm <= most_mm,
                "a length in mm up to four times the longer side",
            ),
            ("poissons_ratio", self.poissons_ratio, (0.0..0.5).contains(&self.poissons_ratio), "0 to below 0.5"),
        ];
        let is_soft = |modulus: f64| modulus > 0.0 && modulus <= MOST_STIFFNESS_MPA;
        let modulus = self.youngs_modulus_mpa.map(|modulus| {
            ("youngs_modulus_mpa", modulus, is_soft(modulus), "a stiffness above 0 and up to 10000 MPa")
        });
        match checks.into_iter().chain(modulus).find(|&(_, _, is_allowed, _)| !is_allowed) {
            Some((key, value, _, allowed)) => Err(BlockError { key, value, allowed }),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_incompressible_or_flat_block_is_refused() {
        let block =
            GelBlock { size_mm: [30.0, 30.0], thickness_mm: 10.0, poissons_ratio: 0.48, youngs_modulus_mpa: Some(0.6) };
        assert_eq!(block.validate(), Ok(()));
        let error = GelBlock { poissons_ratio: 0.5, ..block }.validate().unwrap_err();
        assert_eq!(error.to_string(), "poissons_ratio is 0.5: 0 to below 0.5 is allowed");
        assert!(GelBlock { thickness_mm: 0.0, ..block }.validate().is_err());
        let error = GelBlock { thickness_mm: 10_000.0, ..block }.validate().unwrap_err();
        assert_eq!(
            error.to_string(),
            "thickness_mm is 10000: a length in mm up to four times the longer side is allowed"
        );
        assert!(GelBlock { youngs_modulus_mpa: Some(1e300), ..block }.validate().is_err());
        assert!(GelBlock { youngs_modulus_mpa: Some(f64::NAN), ..block }.validate().is_err());
    }
}

//! The fitted line from the density feature to depth.
//!
//! [Du2021] fits one line over presses of known depth. The feature goes with the inverse of the surface's areal
//! stretch, so the line is a small-range approximation: deep presses read too shallow.
//!
//! [Du2021]: https://doi.org/10.1109/LRA.2021.3061306

use fingervision_image::Image;
use serde::{Deserialize, Serialize};

use crate::ParameterError;

/// `depth = slope · feature + intercept`, a fit that belongs to one sensor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DepthLine {
    /// Depth per unit of the feature `1 − density`, mm.
    pub slope_mm: f64,
    /// Depth where the density is at rest, mm. It lands on every untouched pixel.
    pub intercept_mm: f64,
}

impl DepthLine {
    /// Checks that the line is finite.
    ///
    /// # Errors
    ///
    /// [`ParameterError`] names the first value that is not.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let (slope, intercept) = (self.slope_mm, self.intercept_mm);
        ParameterError::unless(slope.is_finite(), "depth.density.slope_mm", slope, "any finite length, mm")?;
        ParameterError::unless(intercept.is_finite(), "depth.density.intercept_mm", intercept, "any finite length, mm")
    }

    /// Depth in mm, positive pressed in, of one value of the feature `1 − density`.
    #[must_use]
    pub fn depth_mm(&self, feature: f32) -> f32 {
        self.slope_mm as f32 * feature + self.intercept_mm as f32
    }

    /// Writes the depth in mm, positive pressed in, at every pixel of `feature`. Nothing is clamped: a bulge reads
    /// negative.
    ///
    /// # Panics
    ///
    /// If the images differ in size.
    pub fn depth_into(&self, feature: &Image<f32>, depth: &mut Image<f32>) {
        assert_eq!(feature.size(), depth.size(), "size of the depth");
        for (depth, &feature) in depth.values_mut().iter_mut().zip(feature.values()) {
            *depth = self.depth_mm(feature);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_is_not_clamped() {
        let line: DepthLine = toml::from_str("slope_mm = 15.0\nintercept_mm = 0.5").unwrap();
        line.validate().unwrap();
        let feature = Image::from_vec(3, 1, vec![-0.1, 0.0, 0.2]).unwrap();
        let mut depth = Image::filled(3, 1, f32::NAN);
        line.depth_into(&feature, &mut depth);
        for (depth, expected) in depth.values().iter().zip([-1.0, 0.5, 3.5]) {
            assert!((depth - expected).abs() < 1e-6, "{depth} mm, expected {expected} mm");
        }
    }

    #[test]
    fn a_line_without_end_is_refused() {
        let error = DepthLine { slope_mm: f64::INFINITY, intercept_mm: 0.0 }.validate().unwrap_err();
        assert_eq!(error.to_string(), "depth.density.slope_mm = inf is out of range: any finite length, mm");
        let error = DepthLine { slope_mm: 1.0, intercept_mm: f64::NAN }.validate().unwrap_err();
        assert_eq!(error.key, "depth.density.intercept_mm");
    }
}

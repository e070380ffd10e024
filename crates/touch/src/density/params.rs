//! Parameters of the density.

use serde::{Deserialize, Serialize};

use crate::{GuidedFilterParams, ParameterError};

/// How the Gaussians are summed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DensityMethod {
    /// Cubic B-splines on the pixel grid, smoothed: within 5e-4 of the exact sum at σ = 2 px, 2.5e-3 at 1.5 px; relative
    /// to the density where that exceeds 1.
    #[default]
    Fast,
    /// Every Gaussian within 5σ in `f64`: the definition. Seconds for a frame.
    Exact,
}

/// Parameters of the density and of the filter that smooths it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DensityParams {
    /// Standard deviation σ of the Gaussian that every moved point carries, px.
    pub sigma_px: f64,
    /// How the Gaussians are summed.
    pub method: DensityMethod,
    /// The guided filter over the density feature.
    pub filter: GuidedFilterParams,
}

impl Default for DensityParams {
    /// σ = 2 px, as in [Du2021], summed fast.
    ///
    /// [Du2021]: https://doi.org/10.1109/LRA.2021.3061306
    fn default() -> Self {
        Self { sigma_px: 2.0, method: DensityMethod::default(), filter: GuidedFilterParams::default() }
    }
}

impl DensityParams {
    /// Checks every value against its range.
    ///
    /// # Errors
    ///
    /// [`ParameterError`] names the first value out of range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        // Below 1.5 px the pixel grid is too coarse for the Gaussian; above 8 px it blurs every contact away.
        let is_allowed = (1.5..=8.0).contains(&self.sigma_px);
        ParameterError::unless(is_allowed, "density.sigma_px", self.sigma_px, "1.5 to 8 px")?;
        self.filter.validate()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_profile_may_leave_everything_out() {
        let params: DensityParams = toml::from_str("").unwrap();
        assert_eq!(params, DensityParams::default());
        params.validate().unwrap();
        let params: DensityParams = toml::from_str("method = 'exact'\nfilter = { radius_px = 12 }").unwrap();
        assert_eq!((params.method, params.filter.radius_px), (DensityMethod::Exact, 12));
    }

    #[test]
    fn an_unknown_key_is_refused() {
        assert!(toml::from_str::<DensityParams>("sigma = 2.0").is_err());
    }

    #[test]
    fn a_value_out_of_range_is_named() {
        for sigma_px in [0.5, 9.0, f64::NAN] {
            let error = DensityParams { sigma_px, ..DensityParams::default() }.validate().unwrap_err();
            assert_eq!(error.to_string(), format!("density.sigma_px = {sigma_px} is out of range: 1.5 to 8 px"));
        }
    }
}

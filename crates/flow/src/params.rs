//! Parameters of the flow.

use crate::{FlowError, SearchParams};
use serde::{Deserialize, Serialize};

/// The method of the flow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// Dense inverse search alone, the fastest: finest level 2, no variational refinement.
    Ultrafast,
    /// Dense inverse search alone: finest level 2, with variational refinement.
    Fast,
    /// Dense inverse search alone: finest level 1, denser patches, with variational refinement.
    Medium,
    /// Coupled affine patches at full size. Dense inverse search only finds the initial flow of a cold start, and lost
    /// areas.
    #[default]
    Affine,
}

impl Preset {
    /// The inverse search that belongs to the preset.
    #[must_use]
    pub fn search(self) -> SearchParams {
        match self {
            Self::Ultrafast => SearchParams::ultrafast(),
            Self::Fast => SearchParams::fast(),
            Self::Medium => SearchParams::medium(),
            // The affine patches need the search only for a cold start and for lost areas, so it may take more time.
            Self::Affine => SearchParams { finest_level: 0, coarse_reach: 10, ..SearchParams::medium() },
        }
    }
}

/// Parameters of the flow.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FlowParams {
    /// The method of the flow.
    pub preset: Preset,
    /// Pyramid level where the inverse search ends, 0 for full size; absent: that of the preset.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub finest_level: Option<usize>,
    /// Whether the full-size patches use red, green and blue where the frames have them.
    pub colour: bool,
    /// Standard deviation of the image noise, grey levels per channel, on a pattern with strong contrast. It scales the coupling of
    /// neighbouring patches and the predicted deviation. On a weaker contrast it is reduced in proportion; where frames differ from
    /// the reference by much more, it is increased ([`FlowEstimator::adapt`](crate::FlowEstimator::adapt)).
    pub noise_levels: f32,
    /// All parameters of the inverse search, missing ones as in the preset medium; absent: those of the preset.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub search: Option<SearchParams>,
    /// The affine patches.
    pub affine: AffineParams,
    /// Limits for a valid measurement.
    pub validity: ValidityParams,
}

impl Default for FlowParams {
    fn default() -> Self {
        Self {
            preset: Preset::Affine,
            finest_level: None,
            colour: true,
            noise_levels: 2.0,
            search: None,
            affine: AffineParams::default(),
            validity: ValidityParams::default(),
        }
    }
}

impl FlowParams {
    /// The inverse search for these parameters.
    #[must_use]
    pub fn search(&self) -> SearchParams {
        let search = self.search.unwrap_or_else(|| self.preset.search());
        SearchParams { finest_level: self.finest_level.unwrap_or(search.finest_level), ..search }
    }

    /// Checks that every value is in its range.
    ///
    /// # Errors
    ///
    /// [`FlowError::Parameter`] naming the first value that is not.
    pub fn validate(&self) -> Result<(), FlowError> {
        let noise = f64::from(self.noise_levels);
        FlowError::check((0.01..=64.0).contains(&noise), "noise_levels", noise, "0.01 to 64 grey levels")?;
        let finest = self.finest_level.unwrap_or(0);
        FlowError::check(finest <= 8, "finest_level", finest as f64, "0 to 8")?;
        self.search().validate()?;
        self.affine.validate()?;
        self.validity.validate()
    }
}

/// Parameters of the coupled affine patches.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AffineParams {
    /// Coarsest pyramid level at which patches follow the motion since the start.
    pub coarsest_level: usize,
    /// Gauss–Newton steps at full size after a start from the previous flow; more follow while patches still move. If above 1,
    /// the first of them uses grey on every other row.
    pub steps: usize,
    /// Gauss–Newton steps at full size after a start from the search.
    pub search_steps: usize,
    /// Gauss–Newton steps of the finer patches where the flow is rough; 0: no finer patches.
    pub fine_steps: usize,
    /// With colour, every n-th row is matched: 1, 2, 4 or 8. The three channels compensate for the rows that are left
    /// out.
    pub colour_row_step: usize,
    /// Conjugate-gradient iterations of every step, except those at full size that others follow: these have three.
    pub iterations: usize,
    /// Expected difference between the displacements that two neighbouring patches predict half-way between them, px.
    pub continuity_px: f32,
    /// Expected change of the flow's gradient from a patch to its neighbour, px per patch distance.
    pub curvature_px: f32,
    /// Roughness at which the coupling of two neighbours is halved, dimensionless. The roughness is the sum of the
    /// squares of the two quantities above, each relative to its expected value.
    pub bond_tolerance: f32,
}

impl Default for AffineParams {
    fn default() -> Self {
        Self {
            coarsest_level: 3,
            steps: 1,
            search_steps: 5,
            fine_steps: 2,
            colour_row_step: 2,
            iterations: 5,
            continuity_px: 0.0065,
            curvature_px: 0.011,
            bond_tolerance: 2.7,
        }
    }
}

impl AffineParams {
    fn validate(&self) -> Result<(), FlowError> {
        let check = FlowError::check;
        check(self.coarsest_level <= 8, "affine.coarsest_level", self.coarsest_level as f64, "0 to 8")?;
        check(self.fine_steps <= 1000, "affine.fine_steps", self.fine_steps as f64, "0 to 1000")?;
        let row_step = self.colour_row_step;
        check([1, 2, 4, 8].contains(&row_step), "affine.colour_row_step", row_step as f64, "1, 2, 4 or 8 rows")?;
        for (name, count) in [
            ("affine.steps", self.steps),
            ("affine.search_steps", self.search_steps),
            ("affine.iterations", self.iterations),
        ] {
            check((1..=1000).contains(&count), name, count as f64, "1 to 1000")?;
        }
        for (name, value) in [
            ("affine.continuity_px", self.continuity_px),
            ("affine.curvature_px", self.curvature_px),
            ("affine.bond_tolerance", self.bond_tolerance),
        ] {
            check((1e-6..=1e12).contains(&value), name, f64::from(value), "1e-6 to 1e12")?;
        }
        Ok(())
    }
}

/// Limits for a valid measurement.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ValidityParams {
    /// A patch fails if the mean square of its residual exceeds this part of the template's variance, dimensionless.
    pub max_unexplained: f32,
    /// A residual below this many standard deviations of the noise never makes a patch fail, dimensionless.
    pub noise_floor: f32,
    /// A pixel is valid if its predicted standard deviation is at most this, px.
    pub max_deviation_px: f32,
    /// A pixel is valid if forward and backward flow together end at most this far from it, px. Absent: not checked.
    /// The check computes a second flow for every frame, from the frame back to the reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_round_trip_px: Option<f32>,
}

impl Default for ValidityParams {
    fn default() -> Self {
        Self { max_unexplained: 0.4, noise_floor: 2.0, max_deviation_px: 0.25, max_round_trip_px: None }
    }
}

impl ValidityParams {
    fn validate(&self) -> Result<(), FlowError> {
        let check = FlowError::check;
        let part = f64::from(self.max_unexplained);
        check(part > 0.0 && part <= 1.0, "validity.max_unexplained", part, "above 0, at most 1")?;
        let floor = f64::from(self.noise_floor);
        check((0.0..=1000.0).contains(&floor), "validity.noise_floor", floor, "0 to 1000")?;
        let deviation = f64::from(self.max_deviation_px);
        check(deviation > 0.0 && deviation.is_finite(), "validity.max_deviation_px", deviation, "above 0 px")?;
        let trip = self.max_round_trip_px.map_or(1.0, f64::from);
        check(trip > 0.0 && trip.is_finite(), "validity.max_round_trip_px", trip, "above 0 px")
    }
}

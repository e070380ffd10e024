//! The result of a gel fit: values, their deviations, and those written to the profile.

use fingervision_elastic::GelBlock;
use fingervision_image::Image;
use serde::Serialize;

use super::estimate::{GelEstimate, Why, estimate, modulus_estimate};
use super::fit::{self, Settled};
use super::forward::Explained;
use super::look::Look;
use super::modulus::modulus;
use super::press_report::{GelPressReport, press_reports};
use super::thresholds::THRESHOLDS;
use super::{Fitted, GelFitError, GelPress, ResidualGrid, Unknowns, warnings};

/// Error of linear elasticity, of the search for contact and of the grid, whatever the data, one standard deviation: of
/// ν, of ln thickness and of ln E. Root mean squares over simulated presses; `docs/gel-from-presses.md` lists them.
const MODEL: [f64; 3] = [0.015, 0.04, 0.05];
/// Added to it per unit of the mismatch, as a logarithm, between the depth that was found and the known one.
const BY_MISMATCH: [f64; 3] = [0.1, 0.5, 0.5];

/// The values for the profile's `[gel]`: those fitted and determined.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GelTable {
    /// Poisson's ratio.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub poissons_ratio: Option<f64>,
    /// Thickness, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thickness_mm: Option<f64>,
    /// Young's modulus, `MPa`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub youngs_modulus_mpa: Option<f64>,
}

/// The result of a gel fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GelReport {
    /// Poisson's ratio, thickness, Young's modulus.
    pub estimates: [GelEstimate; 3],
    /// The gel that was fitted.
    #[serde(skip)]
    pub(super) gel: GelBlock,
    /// Correlation of Poisson's ratio with thickness; none where one is fixed.
    pub correlation: Option<f64>,
    /// Unexplained motion around contact, root mean square over the depth: by the profile's gel.
    pub unexplained_before: f64,
    /// The same by the fitted gel.
    pub unexplained: f64,
    /// One for each press, in the given order.
    pub presses: Vec<GelPressReport>,
    /// The residual around the fitted gel.
    pub residual: ResidualGrid,
    /// Unexplained motion around contact in the deepest frame, as parts of its depth: by the profile's gel and by the
    /// fitted one.
    #[serde(skip)]
    pub(super) maps: [Image<f32>; 2],
    /// Rounds of finding contact and fitting.
    pub rounds: usize,
    /// Warnings.
    pub warnings: Vec<String>,
}

impl GelReport {
    pub(super) fn new(
        presses: &[GelPress],
        fitted: Fitted,
        start: GelBlock,
        unknowns: Unknowns,
    ) -> Result<Self, GelFitError> {
        let Fitted { after, looks, before, mut models, rounds } = fitted;
        let gel = after.gel;
        let free = [unknowns.poissons_ratio, unknowns.thickness];
        let model = model(&looks);
        let covariance = with_model(after.covariance, free, model);
        let stiff = unknowns.youngs_modulus.then(|| modulus(&looks, &after, covariance)).flatten();
        let has_forces = looks.iter().any(|look| look.force_n.is_some());
        let modulus_mpa = stiff.map(|stiff| stiff.youngs_modulus_mpa).or(start.youngs_modulus_mpa);
        let correlation = after.correlation;
        let is_wide = looks.iter().all(|look| look.radius_mm() > THRESHOLDS.wide * gel.thickness_mm);
        let is_alike = correlation.is_some_and(|correlation| correlation.abs() > THRESHOLDS.alike);
        let why = Why::new(is_wide, is_alike);
        let [ratio, thickness] =
            [0, 1].map(|i| free[i].then(|| (covariance[i][i].sqrt(), after.covariance[i][i].sqrt())));
        let h = gel.thickness_mm;
        let estimates = [
            estimate(
                "poissons_ratio",
                Some(start.poissons_ratio),
                Some(gel.poissons_ratio),
                ratio,
                THRESHOLDS.determined[0],
                why,
            ),
            estimate(
                "thickness_mm",
                Some(start.thickness_mm),
                Some(h),
                thickness.map(|(all, scatter)| (h * all, h * scatter)),
                h * THRESHOLDS.determined[1],
                why,
            ),
            modulus_estimate(
                start.youngs_modulus_mpa,
                stiff,
                (unknowns.youngs_modulus, has_forces),
                model[2],
                why.of_forces(),
            ),
        ];
        let reports = press_reports(presses, (&looks, &after), &before, modulus_mpa);
        let unexplained = fit::unexplained_by(&looks, &after.explained);
        let maps = maps(&looks, &after, &before);
        let (before_looks, explained): (Vec<_>, Vec<_>) = before.into_iter().unzip();
        Ok(Self {
            warnings: warnings::of_presses(presses, &reports, unexplained, &estimates),
            residual: ResidualGrid::about(&gel, &looks, &mut models, &covariance)?,
            unexplained_before: fit::unexplained_by(&before_looks, &explained),
            unexplained,
            gel,
            estimates,
            correlation,
            presses: reports,
            maps,
            rounds,
        })
    }

    /// The values for the profile's `[gel]`; none where nothing is determined.
    #[must_use]
    pub fn table(&self) -> Option<GelTable> {
        let [poissons_ratio, thickness_mm, youngs_modulus_mpa] =
            [0, 1, 2].map(|i| self.estimates[i].value.filter(|_| self.estimates[i].is_determined));
        let table = GelTable { poissons_ratio, thickness_mm, youngs_modulus_mpa };
        self.estimates.iter().any(|estimate| estimate.is_determined).then_some(table)
    }
}

/// The error of the model: of ν, of ln thickness and of ln E.
fn model(looks: &[Look]) -> [f64; 3] {
    let weight = |look: &Look| (look.weight_per_mm * look.depth_mm).powi(2);
    let mismatch =
        looks.iter().map(|look| weight(look) * look.mismatch()).sum::<f64>() / looks.iter().map(weight).sum::<f64>();
    [0, 1, 2].map(|i| MODEL[i].hypot(BY_MISMATCH[i] * mismatch))
}

fn with_model(mut covariance: [[f64; 2]; 2], free: [bool; 2], model: [f64; 3]) -> [[f64; 2]; 2] {
    for i in 0..2 {
        if free[i] {
            covariance[i][i] += model[i].powi(2);
        }
    }
    covariance
}

/// The unexplained motion of the deepest frame, by the profile's gel and by the fitted one.
fn maps(looks: &[Look], after: &Settled, before: &[(Look, Explained)]) -> [Image<f32>; 2] {
    let depth = |look: &Look| look.depth_mm;
    let deepest = |a: &(&Look, &Explained), b: &(&Look, &Explained)| depth(a.0).total_cmp(&depth(b.0));
    let map = |(look, made)| fit::unexplained_map(look, made);
    let empty = || Image::filled(1, 1, f32::NAN);
    [
        before.iter().map(|(look, made)| (look, made)).max_by(deepest).map_or_else(empty, map),
        looks.iter().zip(&after.explained).max_by(deepest).map_or_else(empty, map),
    ]
}

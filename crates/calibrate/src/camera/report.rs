//! The result of a camera calibration, for people and for programs.

use fingervision_optics::CameraParams;
use serde::Serialize;

use super::observability::{Estimate, Knowledge};
use super::prior::Priors;
use super::thresholds::THRESHOLDS;
use super::{BoardError, BoardFlow, CameraFit, Prior, ResidualMap, ResidualTable, Unknown};

/// A fitted camera with everything reported about it. `Display` is the report for people.
#[derive(Debug, Clone, Serialize)]
pub struct CameraReport {
    /// The camera, as written to a profile.
    pub camera: CameraParams,
    /// The slides that it was fitted to.
    pub slides: Vec<SlideReport>,
    /// Residuals before and after, px.
    pub residuals: ResidualTable,
    /// Mean residual after, on the board, mm.
    pub residual_mm: f64,
    /// Residual after over before.
    pub after_over_before: f64,
    /// Residual of the nodes kept for the test over that of the fitted ones.
    pub test_over_after: f64,
    /// Pixels of a millimetre in the middle of the picture.
    pub px_per_mm: f64,
    /// Every unknown, and the combinations that the slides do not determine.
    #[serde(flatten)]
    pub knowledge: Knowledge,
    /// The priors, by name.
    pub priors: Vec<(&'static str, Prior)>,
    /// Whether the origin was set to the point that the middle of the picture shows.
    pub origin_is_middle: bool,
    /// Number of evaluations of the flow of all nodes.
    pub evaluations: usize,
    #[serde(skip)]
    fit: CameraFit,
}

/// A fitted slide.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SlideReport {
    /// Number of images.
    pub images: usize,
    /// Columns and rows of the region of interest, px.
    pub size: (usize, usize),
    /// Length of a step, mm.
    pub step_mm: f64,
    /// Direction, degrees from x towards y.
    pub direction_deg: f64,
    /// The flow of a step, median over the image, px.
    pub usual_px: [f64; 2],
    /// Tracked nodes of the grid.
    pub nodes: usize,
}

impl CameraReport {
    /// The report on a fit to these flows with these priors.
    #[must_use]
    pub fn new(fit: CameraFit, flows: &[BoardFlow], priors: &Priors) -> Self {
        let table = fit.table;
        let slide = |flow: &BoardFlow| SlideReport {
            images: flow.images,
            size: flow.size,
            step_mm: flow.slide.step_mm,
            direction_deg: flow.slide.direction_rad.to_degrees(),
            usual_px: flow.usual_px,
            nodes: flow.nodes.len(),
        };
        let known = Unknown::ALL.into_iter().map(|unknown| (unknown.name(), priors.of(unknown)));
        Self {
            camera: fit.params,
            slides: flows.iter().map(slide).collect(),
            residuals: table,
            residual_mm: table.after.mean_px / fit.px_per_mm,
            after_over_before: table.after.mean_px / table.before.mean_px,
            test_over_after: table.test.mean_px / table.after.mean_px,
            px_per_mm: fit.px_per_mm,
            knowledge: fit.knowledge.clone(),
            priors: known.filter(|(_, prior)| prior.deviation.is_finite()).collect(),
            origin_is_middle: fit.origin_is_middle,
            evaluations: fit.evaluations,
            fit,
        }
    }

    /// Refuses a camera that no sensor can have, that does not explain its recordings, or whose focal length or distance
    /// is not determined.
    ///
    /// # Errors
    ///
    /// [`BoardError::Impossible`], [`BoardError::Useless`] or [`BoardError::NotDetermined`].
    pub fn check(&self) -> Result<(), BoardError> {
        let residual_px = self.residuals.after.mean_px;
        if residual_px > THRESHOLDS.most_residual_px {
            return Err(BoardError::Useless { residual_px, most_px: THRESHOLDS.most_residual_px });
        }
        let Some(slide) = self.slides.first() else { return Ok(()) };
        let widths = self.camera.focal_length_px[0] / slide.size.0 as f64;
        let values = [
            ("distance to the board", self.camera.translation_mm[2], "mm", THRESHOLDS.distances_mm),
            ("focal length", widths, "widths of the image", THRESHOLDS.focal_lengths),
        ];
        match values.into_iter().find(|(_, value, _, range)| !(range[0]..=range[1]).contains(value)) {
            Some((what, value, unit, range)) => Err(BoardError::Impossible { what, value, unit, range }),
            None => self.check_uncertainty(),
        }
    }

    fn check_uncertainty(&self) -> Result<(), BoardError> {
        let most_part = THRESHOLDS.most_uncertain;
        match self.least_determined() {
            Some((Estimate { name, value, .. }, uncertainty)) if uncertainty > most_part * value.abs() => {
                Err(BoardError::NotDetermined { name, value: *value, uncertainty, most_part })
            }
            _ => Ok(()),
        }
    }

    /// A sentence on focal length or distance, if one of them contradicts its prior, or is uncertain.
    #[must_use]
    pub fn remark(&self) -> Option<String> {
        self.contradiction().or_else(|| self.uncertain_length())
    }

    /// A length far from its prior: the prior or the board's step is wrong.
    fn contradiction(&self) -> Option<String> {
        self.lengths().find_map(|Estimate { name, value, .. }| {
            let (_, prior) = self.priors.iter().find(|(of, _)| of == name)?;
            let off = (value - prior.value).abs() / prior.deviation;
            (off > THRESHOLDS.contradiction).then(|| {
                format!(
                    "{name} = {value:.1} differs from its prior, {} ± {}, by {off:.0} standard deviations: check the priors and \
                     --step-mm",
                    prior.value, prior.deviation
                )
            })
        })
    }

    fn uncertain_length(&self) -> Option<String> {
        let (Estimate { name, value, .. }, uncertainty) = self.least_determined()?;
        let part = uncertainty / value.abs();
        (part > THRESHOLDS.remarked_uncertainty).then(|| {
            format!(
                "{name} = {value:.1} ± {uncertainty:.1} is uncertain by {:.0} %: measure the distance from the lens to the board \
                 and give it, as in --prior distance_mm=25±0.5",
                100.0 * part
            )
        })
    }

    /// Of focal length and distance, the one with the larger relative uncertainty, and its uncertainty.
    fn least_determined(&self) -> Option<(&Estimate, f64)> {
        let part = |(estimate, uncertainty): &(&Estimate, f64)| uncertainty / estimate.value.abs();
        let known = self.lengths().filter_map(|estimate| Some((estimate, estimate.uncertainty?)));
        known.max_by(|a, b| part(a).total_cmp(&part(b)))
    }

    /// Focal length and distance.
    fn lengths(&self) -> impl Iterator<Item = &Estimate> {
        let names = [Unknown::Distance, Unknown::FocalLength].map(Unknown::name);
        self.knowledge.estimates.iter().filter(move |estimate| names.contains(&estimate.name))
    }

    /// The residuals of every slide over the picture, before and after.
    pub(super) fn maps(&self) -> &[ResidualMap] {
        &self.fit.maps
    }
}

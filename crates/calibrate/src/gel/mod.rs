//! Fits a gel to presses of known depth: Poisson's ratio, thickness and Young's modulus.
//!
//! In contact the displacement of the gel is known: the depth from the indenter, the motion along the surface from the
//! flow. Linear elasticity then predicts how the gel around contact moves. That depends on two numbers: Poisson's
//! ratio, which determines whether the gel is pushed outwards or drawn in, and the thickness, which determines how far
//! the effect of a press reaches. Both are fitted to the flow around contact. Known forces then give Young's modulus,
//! to which they are proportional; without forces it cannot be determined.
//!
//! Depth and outline of contact are found by the elastic inverse ([`ElasticDepth`]), with the gel that is being fitted,
//! in rounds. Its depths are scaled until the deepest is the known one. Only shallow frames are used, because the
//! deviation of a neo-Hookean gel from linear elasticity grows with the square of depth over thickness.

mod error;
mod estimate;
mod fit;
mod forward;
mod grid;
mod look;
mod modulus;
mod picture;
mod press;
mod press_report;
mod report;
#[cfg(test)]
mod tests;
mod text;
mod thresholds;
mod warnings;

use fingervision_elastic::GelBlock;
use fingervision_optics::Camera;
use fingervision_touch::{ElasticDepth, MOST_UNEXPLAINED, Profile};

pub use error::GelFitError;
pub use estimate::GelEstimate;
pub use grid::ResidualGrid;
pub use press::{GelPress, GelPressRecorder};
pub use press_report::{FrameReport, GelPressReport};
pub use report::{GelReport, GelTable};

use fit::{Fit, Settled};
use forward::{Explained, Models};
use look::{Known, Look};
use thresholds::THRESHOLDS;

/// The values that are fitted; the others keep the profile's value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unknowns {
    /// Poisson's ratio.
    pub poissons_ratio: bool,
    /// The thickness.
    pub thickness: bool,
    /// Young's modulus; needs forces.
    pub youngs_modulus: bool,
}

impl Unknowns {
    /// Nothing is fitted.
    const NONE: Self = Self { poissons_ratio: false, thickness: false, youngs_modulus: false };
}

/// Rounds of finding contact and fitting.
const MOST_ROUNDS: usize = 4;
/// Changes of ν and ln thickness from one round to the next below which the rounds end.
const SAME: [f64; 2] = [3e-3, 6e-3];

/// Fits the gel of a profile to presses.
///
/// # Errors
///
/// [`GelFitError`] if there is nothing to fit, the presses do not determine it, or the fit does not converge.
pub fn fit_gel(presses: &[GelPress], profile: &Profile, unknowns: Unknowns) -> Result<GelReport, GelFitError> {
    if presses.is_empty() {
        return Err(GelFitError::NoPresses);
    }
    let gel = profile.gel.ok_or(GelFitError::Absent { table: "gel" })?;
    let has_forces = presses.iter().flat_map(|press| &press.frames).any(|frame| frame.force_n.is_some());
    if unknowns.youngs_modulus && !has_forces {
        return Err(GelFitError::NoForces { presses: presses.len() });
    }
    let camera = profile.camera.ok_or(GelFitError::Absent { table: "camera" })?;
    let camera = Camera::new(&camera).map_err(|_| GelFitError::Absent { table: "camera" })?;
    let mut report = fit_determined(presses, gel, unknowns, |gel| looks(presses, profile, &camera, gel))?;
    report.warnings.extend(warnings::of_sensor(&camera, &report.gel, profile.elastic));
    Ok(report)
}

/// Fits the gel; a value that is not determined keeps the profile's value, and the others are fitted again with it.
fn fit_determined(
    presses: &[GelPress],
    start: GelBlock,
    unknowns: Unknowns,
    mut find: impl FnMut(&GelBlock) -> Result<Vec<Look>, GelFitError>,
) -> Result<GelReport, GelFitError> {
    let mut report = GelReport::new(presses, fit_in_rounds(start, unknowns, &mut find)?, start, unknowns)?;
    // A fixed value is not determined, either.
    let [poissons_ratio, thickness] = [0, 1].map(|i| report.estimates[i].is_determined);
    let fewer = Unknowns { poissons_ratio, thickness, ..unknowns };
    if fewer != unknowns && fewer != Unknowns::NONE {
        let [ratio_before, thickness_before, _] = report.estimates;
        report = fit_determined(presses, start, fewer, find)?;
        if unknowns.poissons_ratio && !poissons_ratio {
            report.estimates[0] = ratio_before;
        }
        if unknowns.thickness && !thickness {
            report.estimates[1] = thickness_before;
        }
    }
    Ok(report)
}

/// A gel and the data it was fitted to.
struct Fitted {
    /// The frames as explained by the gel of the profile.
    before: Vec<(Look, Explained)>,
    looks: Vec<Look>,
    after: Settled,
    models: Models,
    rounds: usize,
}

/// Alternates between finding contact in all frames for a gel and fitting the gel to them.
fn fit_in_rounds(
    start: GelBlock,
    unknowns: Unknowns,
    mut find: impl FnMut(&GelBlock) -> Result<Vec<Look>, GelFitError>,
) -> Result<Fitted, GelFitError> {
    // Forces are divided by the modulus, which is not part of the fit.
    let start = GelBlock { youngs_modulus_mpa: None, ..start };
    let mut looks = find(&start)?;
    let mut models = Models::new(looks[0].grid);
    let before = looks.iter().cloned().zip(models.explain(&start, &looks)?).collect();
    let mut gel = start;
    let mut rounds = 0;
    loop {
        rounds += 1;
        let after = Fit::new(&looks, &mut models, &start, unknowns).settle(&gel)?;
        let change = fit::change(&gel, &after.gel);
        gel = after.gel;
        if rounds == MOST_ROUNDS || !fit::is_beyond(change, SAME) {
            let unexplained = fit::unexplained_by(&looks, &after.explained);
            if unexplained > MOST_UNEXPLAINED {
                return Err(GelFitError::Misfit { unexplained });
            }
            return Ok(Fitted { before, looks, after, models, rounds });
        }
        looks = find(&gel)?;
    }
}

/// Finds contact in every frame of every press.
fn looks(presses: &[GelPress], profile: &Profile, camera: &Camera, gel: &GelBlock) -> Result<Vec<Look>, GelFitError> {
    let mut looks = Vec::new();
    let mut inverse: Option<((usize, usize), ElasticDepth)> = None;
    for (press, recorded) in presses.iter().enumerate() {
        if inverse.as_ref().is_none_or(|(size, _)| *size != recorded.size) {
            let made = ElasticDepth::new(camera, gel, recorded.size, &profile.elastic)
                .map_err(|error| crate::depth::tracking(&recorded.name)(error.into()))?;
            inverse = Some((recorded.size, made));
        }
        let Some((_, inverse)) = &mut inverse else { continue };
        inverse.restart();
        let mut found = 0;
        let mut widest_mm: f64 = 0.0;
        for (number, frame) in recorded.frames.iter().enumerate() {
            inverse.solve(&frame.flow, &frame.deviation, &frame.valid);
            let known = Known { press, frame: number, depth_mm: frame.depth_mm, force_n: frame.force_n };
            let Some(look) = Look::new(&inverse.cells(), known, gel) else { continue };
            found += 1;
            widest_mm = widest_mm.max(look.radius_mm());
            looks.extend((look.around.len() >= THRESHOLDS.least_around).then_some(look));
        }
        let name = &recorded.name;
        if found == 0 {
            return Err(GelFitError::NoContact { press: name.clone() });
        }
        if looks.last().is_none_or(|look| look.press != press) {
            return Err(GelFitError::NoSurroundings {
                press: name.clone(),
                radius_mm: widest_mm,
                thickness_mm: gel.thickness_mm,
            });
        }
    }
    Ok(looks)
}

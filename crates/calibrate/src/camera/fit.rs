//! The fit: from the flow of one or more slides to a camera.

use fingervision_optics::{Camera, CameraParams, Radial};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};
use serde::Serialize;

use super::observability::{Knowledge, knowledge};
use super::prior::{PUBLISHED_START, Priors};
use super::problem::{Ending, Problem, Sample};
use super::residuals::{ResidualMap, Residuals, correlated_samples};
use super::thresholds::THRESHOLDS;
use super::unknowns::{Coordinates, Unknown, Unknowns, camera_params};
use super::{BoardError, BoardFlow};

/// This part of the nodes is fitted, the rest is kept for the test, as published.
const FITTED_PART: f64 = 0.8;
/// Seed for the choice of the nodes kept for the test.
const SPLIT_SEED: u64 = 1;
/// Standard deviation of a component of a node's flow relative to the priors, px: more than its noise, which neighbours
/// share.
const COUNTED_DEVIATION_PX: f64 = 0.05;
/// Least assumed deviation, px: the flow is not more accurate.
const LEAST_DEVIATION_PX: f64 = 1e-4;

/// Where the fit begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Start {
    /// The plain camera: upright, without distortion, its scale that of the mean flow.
    #[default]
    Plain,
    /// As published: all zero except a distance of 50 mm and a focal length of 50, here px.
    Published,
}

/// Options of the fit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FitOptions {
    /// The radial distortion's form.
    pub radial: Radial,
    /// Where the fit begins.
    pub start: Start,
}

/// A fitted camera and its accuracy.
#[derive(Debug, Clone)]
pub struct CameraFit {
    /// The camera.
    pub params: CameraParams,
    /// The residuals before and after, of fitted nodes and of those kept for the test.
    pub table: ResidualTable,
    /// The unknowns that the slides determine, and those that they do not.
    pub knowledge: Knowledge,
    /// Standard deviation of a component of a node's flow, px, corrected for the correlation of neighbours.
    pub deviation_px: f64,
    /// Pixels of a millimetre in the middle of the picture.
    pub px_per_mm: f64,
    /// Number of evaluations of the flow of all nodes.
    pub evaluations: usize,
    /// Whether the origin was set to the point that the middle of the picture shows.
    pub origin_is_middle: bool,
    /// Of each slide the residuals on its grid.
    pub maps: Vec<ResidualMap>,
}

/// Mean and standard deviation of the residual's length.
///
/// *Before* is the plain camera: upright, without distortion, its scale that of the mean flow. This is the published
/// start, whose focal length equals its distance, with the unit of a pixel taken from the data.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ResidualTable {
    /// Fitted nodes, plain camera.
    pub before: Residuals,
    /// Fitted nodes, fitted camera.
    pub after: Residuals,
    /// Nodes kept for the test, plain camera.
    pub test_before: Residuals,
    /// Nodes kept for the test, fitted camera.
    pub test: Residuals,
}

/// Fits the camera to the flow of one slide, or of several of one board by one camera.
///
/// Levenberg–Marquardt minimises the squared residuals of the flow, each divided by its standard deviation, plus those
/// of the priors ([Du2021] if there are no priors); first over scale and twist alone, then over all unknowns. A fifth
/// of the nodes is kept for the test. The slides do not determine the position of the origin on the board: unless a
/// prior is given for it, it is set to the point in the middle of the picture.
///
/// # Errors
///
/// [`BoardError::NotConverged`], also if the fit ends but leaves a twentieth of the flow unexplained;
/// [`BoardError::TooLittleSeen`] without any flow.
///
/// [Du2021]: https://doi.org/10.1109/LRA.2021.3061306
pub fn fit_camera(flows: &[BoardFlow], priors: &Priors, options: FitOptions) -> Result<CameraFit, BoardError> {
    let Some(first) = flows.first() else { return Err(BoardError::TooLittleSeen { part: 0.0 }) };
    let (width, height) = (first.size.0 as f64, first.size.1 as f64);
    let coordinates = Coordinates { half_diagonal_px: 0.5 * width.hypot(height), radial: options.radial };
    let samples: Vec<Sample> = flows.iter().flat_map(samples_of).collect();
    let (fitted, kept) = split(&samples);
    let plain = plain_camera(&samples, priors);
    let start = match options.start {
        Start::Plain => plain,
        Start::Published => {
            let mut start = plain;
            (start[Unknown::Distance.index()], start[Unknown::FocalLength.index()]) =
                (PUBLISHED_START, PUBLISHED_START);
            start
        }
    };
    let fit = Fit { priors, coordinates, fitted: &fitted };
    let ending = fit.minimize(&start)?;
    let mut unknowns = ending.unknowns;
    let middle = [0.5 * (width - 1.0), 0.5 * (height - 1.0)];
    let origin_is_middle = ![Unknown::TranslationX, Unknown::TranslationY].iter().any(|&axis| priors.is_given(axis));
    if origin_is_middle {
        unknowns = with_origin_at(&unknowns, middle, options.radial);
    }
    let [before_camera, camera] =
        [plain, unknowns].map(|unknowns| Camera::new(&camera_params(&unknowns, options.radial)));
    let (Ok(before_camera), Ok(camera)) = (before_camera, camera) else { return Err(fit.lost(&ending)) };
    let residuals = |samples: &[Sample], camera| Residuals::of(samples.iter().map(|sample| sample.residual_px(camera)));
    let after = residuals(&fitted, &camera);
    let longest_px = flows.iter().map(|flow| flow.usual_px[0].hypot(flow.usual_px[1])).fold(0.0, f64::max);
    if after.mean_px.is_nan() || after.mean_px > THRESHOLDS.most_unexplained * longest_px {
        return Err(fit.lost(&Ending { reason: "no camera explains the flow".into(), ..ending }));
    }
    let shared = flows.iter().map(|flow| correlated_samples(flow, &camera)).fold(1.0, f64::max);
    // A residual's length holds two components.
    let deviation_px = (after.root_mean_square_px() * (0.5 * shared).sqrt()).max(LEAST_DEVIATION_PX);
    let problem = Problem::new(&fitted, priors, coordinates, deviation_px, &unknowns);
    Ok(CameraFit {
        params: camera_params(&unknowns, options.radial),
        table: ResidualTable {
            before: residuals(&fitted, &before_camera),
            after,
            test_before: residuals(&kept, &before_camera),
            test: residuals(&kept, &camera),
        },
        knowledge: knowledge(&unknowns, &problem.information(), priors),
        deviation_px,
        px_per_mm: camera.mm_per_px(middle).map_or(f64::NAN, f64::recip),
        evaluations: ending.evaluations,
        origin_is_middle,
        maps: flows.iter().map(|flow| ResidualMap::of(flow, &before_camera, &camera)).collect(),
    })
}

/// The data that are the same in all stages.
struct Fit<'a> {
    priors: &'a Priors,
    coordinates: Coordinates,
    fitted: &'a [Sample],
}

impl Fit<'_> {
    fn minimize(&self, start: &Unknowns) -> Result<Ending, BoardError> {
        // Far from the right scale, the fit would use absurd distortion to explain the flow.
        let scaled = self.problem(start).only(&[Unknown::FocalLength, Unknown::RotationZ]).minimize();
        if !scaled.has_converged {
            return Err(self.lost(&scaled));
        }
        let mut ending = self.problem(&scaled.unknowns).minimize();
        ending.evaluations += scaled.evaluations;
        if ending.has_converged { Ok(ending) } else { Err(self.lost(&ending)) }
    }

    fn problem(&self, start: &Unknowns) -> Problem<'_> {
        Problem::new(self.fitted, self.priors, self.coordinates, COUNTED_DEVIATION_PX, start)
    }

    fn camera(&self, ending: &Ending) -> Option<Camera> {
        Camera::new(&camera_params(&ending.unknowns, self.coordinates.radial)).ok()
    }

    fn residuals(&self, camera: &Camera) -> Residuals {
        Residuals::of(self.fitted.iter().map(|sample| sample.residual_px(camera)))
    }

    fn lost(&self, ending: &Ending) -> BoardError {
        let residual_px = self.camera(ending).map_or(f64::NAN, |camera| self.residuals(&camera).mean_px);
        BoardError::NotConverged { reason: ending.reason.clone(), evaluations: ending.evaluations, residual_px }
    }
}

fn samples_of(flow: &BoardFlow) -> impl Iterator<Item = Sample> {
    let step_mm = flow.slide.step_vector_mm();
    flow.nodes.iter().map(move |node| Sample { px: node.px, step_mm, flow_px: node.flow_px })
}

/// A random part to be fitted and the rest, the same for the same number of samples.
fn split(samples: &[Sample]) -> (Vec<Sample>, Vec<Sample>) {
    let mut random = Pcg64Mcg::seed_from_u64(SPLIT_SEED);
    let threshold = (FITTED_PART * f64::from(u32::MAX)) as u32;
    samples.iter().partition(|_| random.next_u32() <= threshold)
}

/// The plain camera at the most likely distance. If a focal length was given and a distance was not, the distance
/// follows from it.
fn plain_camera(samples: &[Sample], priors: &Priors) -> Unknowns {
    let mut unknowns = Unknowns::zeros();
    let length = |[x, y]: [f64; 2]| x.hypot(y);
    let (flow, step): (f64, f64) =
        samples.iter().fold((0.0, 0.0), |sum, sample| (sum.0 + length(sample.flow_px), sum.1 + length(sample.step_mm)));
    let px_per_mm = flow / step;
    let (focal, distance) = (priors.of(Unknown::FocalLength), priors.of(Unknown::Distance));
    let distance_mm = if priors.is_given(Unknown::FocalLength) && !priors.is_given(Unknown::Distance) {
        focal.value / px_per_mm
    } else {
        distance.value
    };
    unknowns[Unknown::Distance.index()] = distance_mm;
    unknowns[Unknown::FocalLength.index()] = px_per_mm * distance_mm;
    for axis in [Unknown::PrincipalX, Unknown::PrincipalY] {
        unknowns[axis.index()] = priors.of(axis).value;
    }
    unknowns
}

/// The same camera with the gel's origin moved along the surface to the point that a pixel shows.
fn with_origin_at(unknowns: &Unknowns, px: [f64; 2], radial: Radial) -> Unknowns {
    let params = camera_params(unknowns, radial);
    let Ok(camera) = Camera::new(&params) else { return *unknowns };
    let Some([x, y]) = camera.surface_point(px, 0.0) else { return *unknowns };
    let moved = camera.camera_from_gel([x, y, 0.0]);
    let mut unknowns = *unknowns;
    for (axis, value) in [Unknown::TranslationX, Unknown::TranslationY, Unknown::Distance].into_iter().zip(moved) {
        unknowns[axis.index()] = value;
    }
    unknowns
}

//! Simulated pairs with exact truth.
//!
//! Colour cells of 4 px turned by 1.5°, blurred by 0.7 px, noise of 2 levels a channel in both frames, 8 bit, 610×450
//! px; a border of 16 px is left out. Both frames have noise of their own, and every seed has a pattern of its own.
//!
//! | name | motion |
//! | --- | --- |
//! | T *d* | shift by *d* px at 33° |
//! | B *A* | round bump, largest displacement *A* px at 80 px from the centre |
//! | S *s* | a square of 150 px scaled by *s*, decaying outside over 15 px |
//! | I B *A* | the bump under light that falls from +15 % on the right to −15 % on the left |

use crate::matcher::Matcher;
use crate::{Asked, Calibration, EvaluateError, Table, end_point_errors, mean, without_border};
use fingervision_flow::{FlowField, FlowParams, Preset};
use fingervision_gel::{Light, Motion, Sheet, SheetRenderer};
use fingervision_image::Pixels;
use rayon::prelude::*;

/// Border that is left out on every side, px.
pub const BORDER_PX: usize = 16;

/// Light 15 % down at the left border and 15 % up at the right one.
pub(crate) const TILTED_LIGHT: Light = Light { left: 0.85, right: 1.15 };

/// A motion to be measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimulatedPair {
    /// Its name in the tables.
    pub name: &'static str,
    /// The motion of the second frame's points.
    pub motion: Motion,
    /// Light of the second frame.
    pub light: Light,
    /// The required mean end-point error, px.
    pub asked_px: f64,
    /// The mean end-point error of `OpenCV`'s inverse search, preset medium, px: a recorded value for
    /// comparison.
    pub opencv_px: f64,
}

impl SimulatedPair {
    /// All pairs of the table, for images of a size whose centre is given.
    #[must_use]
    pub fn all(centre_px: [f64; 2]) -> [Self; 9] {
        let pair = |name, motion, asked_px, opencv_px| Self { name, motion, light: Light::EVEN, asked_px, opencv_px };
        let bump = |amplitude| Motion::radial_bump(centre_px, amplitude);
        let square = |scale| Motion::scaled_square(centre_px, scale);
        [
            pair("T 0.5", Motion::shift(0.5), 0.012, 0.066),
            pair("T 5", Motion::shift(5.0), 0.010, 0.045),
            pair("T 20", Motion::shift(20.0), 0.012, 0.032),
            pair("B 5", bump(5.0), 0.015, 0.046),
            pair("B 10", bump(10.0), 0.020, 0.066),
            pair("B 25", bump(25.0), 0.030, 0.188),
            pair("S 1.1", square(1.1), 0.025, 0.053),
            pair("S 1.2", square(1.2), 0.060, 0.128),
            Self { light: TILTED_LIGHT, ..pair("I B10", bump(10.0), 0.025, 0.074) },
        ]
    }
}

/// The tables of simulated pairs.
#[derive(Debug, Clone, PartialEq)]
pub struct PairTables {
    /// Mean end-point errors, px.
    pub accuracy: Table,
    /// How reliable validity and predicted deviation are, for the default in colour.
    pub calibration: Table,
}

/// The result of one seed of one pair: the error of every variant, and the reliability of the default's deviation.
struct Outcome {
    errors_px: [f64; 5],
    calibration: Calibration,
}

/// The variants, in the order of the columns.
fn variants() -> [FlowParams; 5] {
    let grey = |preset| FlowParams { preset, colour: false, ..FlowParams::default() };
    [FlowParams::default(), grey(Preset::Affine), grey(Preset::Ultrafast), grey(Preset::Fast), grey(Preset::Medium)]
}

/// Measures every pair with `seeds` patterns.
///
/// # Errors
///
/// [`EvaluateError::Flow`] if the default parameters do not fit the frames, which would be a bug.
pub fn measure(seeds: u64) -> Result<PairTables, EvaluateError> {
    let sheet = Sheet::default();
    let pairs = SimulatedPair::all(sheet.centre_px());
    let references = (0..seeds).into_par_iter().map(|seed| {
        let renderer = SheetRenderer::new(&Sheet { pattern_seed: 1 + seed, ..sheet.clone() })?;
        let reference = Pixels::Rgb8(renderer.render(&Motion::STILL, Light::EVEN, noise_seed(seed, 0))?);
        Ok((renderer, reference))
    });
    let references = references.collect::<Result<Vec<_>, EvaluateError>>()?;
    let jobs: Vec<_> = (0..pairs.len()).flat_map(|pair| (0..seeds).map(move |seed| (pair, seed))).collect();
    let outcomes = jobs.into_par_iter().map(|(pair, seed)| {
        let (renderer, reference) = &references[seed as usize];
        outcome(&pairs[pair], renderer, reference, noise_seed(seed, 1 + pair as u64))
    });
    let outcomes = outcomes.collect::<Result<Vec<_>, EvaluateError>>()?;
    Ok(tables(&pairs, outcomes.chunks_exact(seeds.max(1) as usize)))
}

fn noise_seed(seed: u64, frame: u64) -> u64 {
    1000 * seed + frame
}

fn outcome(
    pair: &SimulatedPair,
    renderer: &SheetRenderer,
    reference: &Pixels,
    noise_seed: u64,
) -> Result<Outcome, EvaluateError> {
    let current = Pixels::Rgb8(renderer.render(&pair.motion, pair.light, noise_seed)?);
    let (width, height) = current.size();
    let truth = pair.motion.flow(width, height);
    let truth = FlowField { u: truth.u, v: truth.v };
    let region = without_border((width, height), BORDER_PX);
    let mut outcome = Outcome { errors_px: [0.0; 5], calibration: Calibration::default() };
    for (index, params) in variants().iter().enumerate() {
        let mut matcher = Matcher::new(reference, params)?;
        let estimate = matcher.find(&current)?;
        outcome.errors_px[index] = mean(end_point_errors(&estimate.flow, &truth, region));
        if index == 0 {
            outcome.calibration = Calibration::measure(estimate, &truth, region);
        }
    }
    Ok(outcome)
}

fn tables<'a>(pairs: &[SimulatedPair], outcomes: impl Iterator<Item = &'a [Outcome]>) -> PairTables {
    let mut accuracy = Table::new(
        "Simulated pairs: mean end-point error, px",
        &["default", "worst seed", "grey", "ultrafast", "fast", "medium", "OpenCV medium"],
    );
    let mut calibration = Table::new(
        "Simulated pairs: predicted deviation and validity of the default",
        &["error/deviation", "valid", "wrong (> 1 px)", "of which valid"],
    );
    for (pair, seeds) in pairs.iter().zip(outcomes) {
        let mean_of =
            |variant: usize| seeds.iter().map(|seed| seed.errors_px[variant]).sum::<f64>() / seeds.len() as f64;
        let worst = seeds.iter().map(|seed| seed.errors_px[0]).fold(0.0, f64::max);
        let values = vec![mean_of(0), worst, mean_of(1), mean_of(2), mean_of(3), mean_of(4), pair.opencv_px];
        accuracy.push(pair.name, Some(Asked::AtMost(pair.asked_px)), values);
        let sums = seeds.iter().map(|seed| seed.calibration).fold(Calibration::default(), Calibration::and);
        let values =
            vec![sums.error_over_deviation(), sums.valid_part(), sums.wrong_part(), sums.trusted_part_of_wrong()];
        calibration.push(pair.name, None, values);
    }
    PairTables { accuracy, calibration }
}

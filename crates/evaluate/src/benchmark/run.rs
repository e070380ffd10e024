//! Runs all cases.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use fingervision_calibrate::depth::DepthFit;
use fingervision_flow::FlowField;
use fingervision_gel::{PressCache, Resolution, Scene, SceneError, Truth};
use fingervision_image::Image;
use rayon::prelude::*;

use super::cases::adapt;
use super::{BenchmarkReport, Case, CaseReport, Entry, Extent, Method, MethodScore, Variation};
use crate::experiment::{
    ElasticRun, ExperimentError, Followed, Following, Recording, calibrate, follow_last, profile_with_assignments,
};

/// The settings of a benchmark.
#[derive(Debug)]
pub struct Benchmark<'a> {
    /// How much is computed.
    pub extent: Extent,
    /// The cases, those of [`cases`](super::cases) or some of them.
    pub cases: Vec<Case>,
    /// Values of the tracker that differ from the simulated sensor: keys of the profile with their values.
    pub assignments: &'a [(String, String)],
    /// Other programs.
    pub entries: &'a [Entry],
    /// Where solved presses are kept.
    pub cache: &'a PressCache,
}

/// The fits of every sensor, by the variation's name, for the dense pattern and for dots.
type Fits = BTreeMap<(&'static str, bool), DepthFit>;

impl Benchmark<'_> {
    /// Checks values of the tracker and entries, before anything is solved or written.
    ///
    /// # Errors
    ///
    /// [`ExperimentError`] for a key or a value that no profile has, or an entry without any result.
    pub fn check(&self) -> Result<(), ExperimentError> {
        self.entries.iter().try_for_each(|entry| entry.check(&self.cases))?;
        self.cases.first().map_or(Ok(()), |case| profile_with_assignments(&case.scene, self.assignments).map(drop))
    }

    fn record(&self, scene: &Scene) -> Result<Recording, ExperimentError> {
        Recording::with_assignments(scene, self.assignments, self.cache)
    }
}

/// Runs the benchmark. A case that cannot be solved to its end is skipped and named. `progress` is called after every
/// case and calibration with its name; it can end the run.
///
/// # Errors
///
/// [`ExperimentError`] if a case cannot be drawn, tracked or evaluated, or if a calibration press cannot be solved;
/// [`ExperimentError::Interrupted`] if `progress` ends the run.
pub fn run(
    benchmark: &Benchmark,
    progress: &(dyn Fn(&str) -> ControlFlow<()> + Sync),
) -> Result<BenchmarkReport, ExperimentError> {
    benchmark.check()?;
    let fits = fits(benchmark, progress)?;
    let report = |case: &Case| {
        let report = match report(case, &fits, benchmark) {
            Err(ExperimentError::EndedEarly { scene, reason }) => Err(format!("{scene}: {reason}")),
            report => Ok(report?),
        };
        go_on(progress(&case.name))?;
        Ok(report)
    };
    let cases = benchmark.cases.par_iter().map(report).collect::<Result<Vec<_>, ExperimentError>>()?;
    Ok(BenchmarkReport::new(benchmark.extent, benchmark.assignments, cases))
}

fn go_on(flow: ControlFlow<()>) -> Result<(), ExperimentError> {
    if flow.is_break() { Err(ExperimentError::Interrupted) } else { Ok(()) }
}

/// Calibrates every sensor that a case needs.
fn fits(benchmark: &Benchmark, progress: &(dyn Fn(&str) -> ControlFlow<()> + Sync)) -> Result<Fits, ExperimentError> {
    let needs = |sensor: &Variation, is_dots: bool| {
        let variations = || benchmark.cases.iter().map(|case| case.variation).filter(|one| one.sensor == sensor.name);
        variations().any(|one| one.has_dots || !is_dots)
    };
    let sensors = Variation::ALL.iter().flat_map(|sensor| [(sensor, false), (sensor, true)]);
    let fit = |(variation, is_dots): (&'static Variation, bool)| {
        let record = |scene| {
            let mut scene = variation.apply(scene)?;
            adapt(&mut scene, benchmark.extent, Resolution::Draft)?;
            benchmark.record(&if is_dots { with_dots(scene)? } else { scene })
        };
        let following = if is_dots { Following::Dots } else { Following::Dense };
        let fit = calibrate(&record, following)?;
        go_on(progress(variation.name))?;
        Ok(((variation.name, is_dots), fit))
    };
    // One after another: the nine presses of one sensor already keep all threads busy.
    sensors.filter(|&(sensor, is_dots)| needs(sensor, is_dots)).map(fit).collect()
}

/// The scene with a pattern of 15×15 dots.
pub(crate) fn with_dots(mut scene: Scene) -> Result<Scene, SceneError> {
    scene.set_all([("pattern", "{ kind = \"dots\", dots = [15, 15], levels = [16, 240] }")])?;
    Ok(scene)
}

/// The result of one way of tracking in the last frame.
struct Last {
    feature: Image<f32>,
    valid: Image<u8>,
    flow_error_px: f64,
}

fn last(recording: &Recording, following: Following, each: impl FnMut(Followed<'_>)) -> Result<Last, ExperimentError> {
    follow_last(recording, &recording.profile, following, each, |found| Last {
        feature: found.feature.clone(),
        valid: found.valid.clone(),
        flow_error_px: flow_error_px(found.flow, found.valid, &recording.truth),
    })
}

/// Mean end-point error over the pixels that are valid and visible, px.
pub(crate) fn flow_error_px(flow: &FlowField, valid: &Image<u8>, truth: &Truth) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for pixel in 0..valid.values().len() {
        let [u, v] = truth.flow.values()[pixel].map(f64::from);
        if valid.values()[pixel] != 0 && truth.visible.values()[pixel] != 0 && u.is_finite() {
            let found = [flow.u.values()[pixel], flow.v.values()[pixel]].map(f64::from);
            sum += (found[0] - u).hypot(found[1] - v);
            count += 1.0;
        }
    }
    sum / count
}

fn report(case: &Case, fits: &Fits, benchmark: &Benchmark) -> Result<CaseReport, ExperimentError> {
    let recording = benchmark.record(&case.scene)?;
    let scorer = recording.scorer();
    let mut elastic = ElasticRun::new(&recording)?;
    let dense = last(&recording, Following::Dense, |found| elastic.take(found))?;
    let dots = if case.variation.has_dots {
        let recording = benchmark.record(&with_dots(case.scene.clone())?)?;
        Some(last(&recording, Following::Dots, |_| ())?)
    } else {
        None
    };
    let mut scores = Vec::new();
    for method in Method::ALL {
        let is_dots = method.following() == Following::Dots;
        let (Some(found), Some(fit)) =
            (if is_dots { dots.as_ref() } else { Some(&dense) }, fits.get(&(case.variation.sensor, is_dots)))
        else {
            continue;
        };
        if let Some(depth) = method.depth(&found.feature, fit, &recording) {
            scores.push(MethodScore::new(method.name(), scorer.score(&depth, &found.valid)));
        }
    }
    scores.push(elastic.score(&recording, &scorer).0.into());
    for entry in benchmark.entries {
        if let Some([depth, valid]) = entry.read(case)? {
            let score = scorer.score(&depth.values, &valid.mask());
            scores.push(MethodScore::new(&entry.name, score));
        }
    }
    Ok(CaseReport {
        case: case.name.clone(),
        scene: case.base,
        variation: case.variation.name,
        depth_mm: recording.depths_mm.last().copied().unwrap_or_default(),
        flow_error_px: dense.flow_error_px,
        scores,
    })
}

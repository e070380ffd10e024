//! The demo without a page: one press to look at as pictures and arrays, compared with its truth.

use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};

use fingervision_evaluate::run::{Errors, FrameReport, Options, Report};
use fingervision_gel::{PressCache, Scene};
use fingervision_simulation::open;
use fingervision_sink::Precision;
use fingervision_touch::Profile;
use serde::Serialize;

use super::{Args, SCENE};
use crate::evaluate;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::part::Part;
use crate::simulation_run::{SimulationRun, SimulationSummary};
use crate::summary::Summary;
use crate::tracking::Run;

/// The folder of a demo if none is given.
const FOLDER: &str = "fingervision-demo";

#[derive(Debug, Serialize)]
struct DemoResult {
    #[serde(flatten)]
    summary: Summary,
    simulation: SimulationSummary,
    truth: Report,
    picture: PathBuf,
}

pub(super) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let folder = args.out.clone().unwrap_or_else(|| FOLDER.into());
    let (sensor, run) = (folder.join("simulation"), folder.join("run"));
    let (simulation, ended) = simulate(args, &sensor)?;
    ended.map_or(Ok(()), Err)?;
    let (summary, ended) = track(args, &sensor, &run)?;
    ended.map_or(Ok(()), Err)?;
    let options = Options::default();
    let (truth, picture) = evaluate::compare([&run, &sensor], &run.join(evaluate::FOLDER), options, args.output)?;
    let result = DemoResult { summary, simulation, truth, picture };
    args.output.result(out, &result, &text(&result))
}

fn simulate(args: &Args, folder: &Path) -> Result<(SimulationSummary, Option<Failure>), Failure> {
    let mut scene = Scene::find(SCENE)?;
    scene.make_draft();
    let simulation = SimulationRun {
        cache: PressCache::standard(),
        has_images: true,
        overwrite: args.overwrites(),
        output: args.output,
        interrupt: Interrupt::listen(),
    };
    simulation.simulate(&scene, folder)
}

fn track(args: &Args, sensor: &Path, folder: &Path) -> Result<(Summary, Option<Failure>), Failure> {
    let run = Run {
        profile: Profile::load(&sensor.join("profile.toml"))?,
        fields: None,
        precision: Precision::default(),
        overlay: None,
        folder: folder.to_owned(),
        overwrite: args.overwrites(),
        part: Part::default(),
        skips_bad_frames: false,
        output: args.output,
    };
    let mut source = open(sensor.join("frames"), &fingervision_source::Options::default())?;
    run.track(source.as_mut())
}

fn text(DemoResult { summary, simulation, truth, picture }: &DemoResult) -> String {
    let mut text = format!("{}\n{summary}", simulation.headline());
    let moved_px = truth.deepest().and_then(|deepest| deepest.true_flow_px);
    if let Some((Errors { mean, .. }, moved_px)) = truth.mean.flow_px.and_then(|flow| flow.everywhere).zip(moved_px) {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "truth    flow error {mean:.3} px on average; the gel moves by up to {moved_px:.1} px");
    }
    if let Some(readout) = true_readout(simulation, truth) {
        let _ = writeln!(text, "truth    {readout}");
    }
    text + &format!("picture  {}", picture.display())
}

/// The true values of the deepest frame, and the errors of its depth and contact.
fn true_readout(simulation: &SimulationSummary, truth: &Report) -> Option<String> {
    let FrameReport { true_depth_mm, errors, .. } = truth.deepest()?;
    let mut text = format!("depth up to {:.2} mm, force {}", (*true_depth_mm)?, simulation.force);
    let depth = errors.depth_mm?;
    let mean = |errors: Option<Errors>| errors.map_or(f64::NAN, |errors| errors.mean);
    let (inside, everywhere) = (mean(depth.inside), mean(depth.everywhere));
    let _ = write!(text, "; depth error {everywhere:.3} mm on average, {inside:.3} mm in contact");
    if let Some(overlap) = errors.contact_overlap {
        let _ = write!(text, "; contact overlaps by {:.0} %", 100.0 * overlap);
    }
    Some(text)
}

//! `fingervision simulate`: simulates a scene and writes frames with exact truth.

use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};

use fingervision_gel::{RandomScenes, ReadyMade, Scene};
use serde::Serialize;

use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::OutputArgs;
use crate::scene_args::SceneArgs;
use crate::simulation_run::{SimulationRun, SimulationSummary};
use crate::whole_number::whole_number;

/// Most random scenes of a call: four digits in a folder's name.
const MOST_RANDOM: u64 = 10_000;

/// Simulate a press: camera images, their exact truth and the profile to track them with
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// A ready-made scene, as in letter (--list names them), or a scene file
    #[arg(required_unless_present_any = ["list", "random"], conflicts_with_all = ["list", "random"])]
    scene: Option<String>,
    /// The folder to write, as in letter: new, empty, or with --overwrite a previous simulation
    #[arg(long, value_name = "DIR", required_unless_present = "list")]
    out: Option<PathBuf>,
    /// List the ready-made scenes
    #[arg(long, conflicts_with_all = ["out", "assignments", "draft", "frames", "no_cache", "truth_only", "seed", "overwrite"])]
    list: bool,
    /// Write N random scenes instead, as in 100, into the folders scene-0000, scene-0001, ...
    #[arg(long, value_name = "N", conflicts_with = "list", value_parser = clap::value_parser!(u64).range(1..=MOST_RANDOM))]
    random: Option<u64>,
    #[command(flatten)]
    scenes: SceneArgs,
    /// Write the truth and the profile, but no images
    #[arg(long)]
    truth_only: bool,
    /// Seed of pattern and noise, as in 7; without it the scene's own. With --random also the seed of the scenes, 0
    /// without it
    #[arg(long, value_parser = whole_number::<u64>)]
    seed: Option<u64>,
    /// Replace a previous simulation in the folder
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    output: OutputArgs,
}

/// A line of `--list`.
#[derive(Debug, Serialize)]
struct Listed {
    name: &'static str,
    about: String,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let Some(folder) = args.out.clone().filter(|_| !args.list) else { return list(args.output, out) };
    let run = SimulationRun {
        cache: args.scenes.cache(),
        has_images: !args.truth_only,
        overwrite: args.overwrite,
        output: args.output,
        interrupt: Interrupt::listen(),
    };
    if let Some(count) = args.random {
        return simulate_random(args, &run, &folder, count, out);
    }
    let mut scene = Scene::find(args.scene.as_deref().unwrap_or_default())?;
    if let Some(seed) = args.seed {
        scene.set_seed(seed);
    }
    let scene = args.scenes.change(scene)?;
    let (summary, failure) = run.simulate(&scene, &folder)?;
    args.output.result(out, &summary, &summary.to_string())?;
    failure.map_or(Ok(()), Err)
}

fn list(output: OutputArgs, out: &mut impl Write) -> Result<(), Failure> {
    let scenes: Vec<Listed> =
        ReadyMade::ALL.iter().map(|ready| Listed { name: ready.name, about: ready.scene().about }).collect();
    let mut text = String::new();
    for Listed { name, about } in &scenes {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{name:23} {about}");
    }
    output.result(out, &scenes, &text)
}

/// Simulates one random scene after another; those whose solution ends early are reported and counted.
fn simulate_random(
    args: &Args,
    run: &SimulationRun,
    folder: &Path,
    count: u64,
    out: &mut impl Write,
) -> Result<(), Failure> {
    let mut summaries: Vec<SimulationSummary> = Vec::new();
    let mut cut_short = Vec::new();
    for (number, scene) in RandomScenes::new(args.seed.unwrap_or_default()).take(count as usize).enumerate() {
        let name = format!("scene-{number:04}");
        let (summary, failure) = run.simulate(&args.scenes.change(scene)?, &folder.join(&name))?;
        summaries.push(summary);
        if run.interrupt.is_asked() {
            args.output.result(out, &summaries, &lines(&summaries))?;
            return failure.map_or(Ok(()), Err);
        }
        if let Some(failure) = failure {
            args.output.note(&format!("{name}: {failure}"));
            cut_short.push(name);
        }
    }
    args.output.result(out, &summaries, &lines(&summaries))?;
    if cut_short.is_empty() {
        return Ok(());
    }
    let (bad, names) = (cut_short.len(), cut_short.join(", "));
    Err(Failure::new(format!("{bad} of {count} scenes ended early: {names}"), "the frames before it can be used"))
}

fn lines(summaries: &[SimulationSummary]) -> String {
    summaries.iter().map(SimulationSummary::line).collect::<Vec<_>>().join("\n")
}

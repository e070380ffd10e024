//! `fingervision demo`: the main job with nothing attached.

use std::io::Write;
use std::path::PathBuf;

use fingervision_sink::Field;
use fingervision_touch::Profile;
use serde::Serialize;

use crate::failure::Failure;
use crate::output::OutputArgs;
use crate::simulated_press::SimulatedPress;
use crate::summary::Summary;
use crate::tracking::Run;
use crate::truth::{TruthComparison, TruthReport};

/// Columns and rows of the simulated camera, px.
const SIZE: (usize, usize) = (320, 240);
/// Where the bump moves the gel farthest, px from its centre.
const RADIUS_PX: f64 = 50.0;
/// How far the bump moves the gel, px.
const AMPLITUDE_PX: f64 = 12.0;
const FRAMES: u64 = 25;
/// The folder of a demo that was not given one.
const FOLDER: &str = "fingervision-demo";

/// Track a simulated press: pictures and arrays to look at, with nothing attached
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The folder to write; without it ./fingervision-demo, where an earlier demo is replaced
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write to the folder without opening a page; this version always does
    #[arg(long)]
    headless: bool,
    #[command(flatten)]
    output: OutputArgs,
}

#[derive(Debug, Serialize)]
struct DemoResult {
    #[serde(flatten)]
    summary: Summary,
    truth: Option<TruthReport>,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let mut source = SimulatedPress::new(SIZE, RADIUS_PX, AMPLITUDE_PX, FRAMES)?;
    let mut comparison = TruthComparison::new(source.press());
    let run = Run {
        profile: Profile { name: "simulated press".into(), ..Profile::default() },
        fields: Some(vec![Field::Flow, Field::Density]),
        folder: args.out.clone().unwrap_or_else(|| FOLDER.into()),
        overwrite: args.out.is_none(),
        output: args.output,
    };
    let (summary, failure) = run.track(&mut source, Some(&mut comparison))?;
    let result = DemoResult { summary, truth: comparison.report() };
    args.output.result(out, &result, &text(&result))?;
    failure.map_or(Ok(()), Err)
}

fn text(DemoResult { summary, truth }: &DemoResult) -> String {
    let truth = truth.map_or_else(String::new, |truth| truth.to_string());
    format!("a simulated press of a round bump on a dense random colour pattern\n{summary}{truth}")
}

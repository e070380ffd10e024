//! `fingervision live`: sensors that run, on a page and in the terminal.

mod sensors;
mod status;

use std::io::Write;

use fingervision_pipeline::{Interest, Pipeline};
use serde::Serialize;

use crate::failure::Failure;
use crate::output::OutputArgs;
use sensors::SensorArgs;
use status::SensorSummary;

/// Track cameras as they see: depth, contact and force at every frame
///
/// Ctrl-C ends it.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    sensors: SensorArgs,
    #[command(flatten)]
    output: OutputArgs,
}

#[derive(Debug, Serialize)]
struct LiveSummary {
    sensors: Vec<SensorSummary>,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let pipeline = Pipeline::prepare(args.sensors.open(args.output)?);
    let messages = pipeline.subscribe(Interest::readings());
    let running = pipeline.start()?;
    let sensors = status::show(running.handles(), &messages, args.output);
    running.stop();
    let text = sensors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    args.output.result(out, &LiveSummary { sensors }, &text)
}

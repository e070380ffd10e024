//! `fingervision live`: sensors that run, on a page and in the terminal.

mod actions;
mod sensors;
mod status;

use std::io::Write;
use std::net::IpAddr;
use std::sync::Arc;

use fingervision_page::{Page, PageOptions};
use fingervision_pipeline::{Interest, Pipeline, Running, Sensor};
use serde::Serialize;

use crate::failure::Failure;
use crate::output::OutputArgs;
use actions::LiveActions;
use sensors::SensorArgs;
use status::SensorSummary;

/// Messages that may wait for the page.
const PAGE_MESSAGES: usize = 512;

/// Track cameras as they see, and show depth, contact and force on a web page
///
/// The address of the page is printed. Ctrl-C ends it.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    sensors: SensorArgs,
    #[command(flatten)]
    page: PageArgs,
    #[command(flatten)]
    output: OutputArgs,
}

#[derive(Debug, Clone, Copy, clap::Args)]
pub(crate) struct PageArgs {
    /// The port of the page; without it 8090 or the next free one
    #[arg(long, value_name = "PORT")]
    port: Option<u16>,
    /// Serve the page at this address instead of 127.0.0.1; other machines can then open it with the printed token
    #[arg(long, value_name = "ADDRESS")]
    bind: Option<IpAddr>,
    /// Track without a page
    #[arg(long, conflicts_with_all = ["port", "bind"])]
    no_page: bool,
}

#[derive(Debug, Serialize)]
struct LiveSummary {
    sensors: Vec<SensorSummary>,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let sensors = args.sensors.open(args.output)?;
    run_sensors(sensors, args.page, args.output, out)
}

/// Runs until all sensors have ended or the user stops it.
pub(crate) fn run_sensors(
    sensors: Vec<Sensor>,
    page: PageArgs,
    output: OutputArgs,
    out: &mut impl Write,
) -> Result<(), Failure> {
    let pipeline = Pipeline::prepare(sensors);
    let messages = pipeline.subscribe(Interest::readings());
    let page_messages = pipeline.subscribe(Interest { capacity: PAGE_MESSAGES, ..Interest::readings() });
    let running = pipeline.start()?;
    let page = page.start(&running, page_messages, output)?;
    let sensors = status::show(running.handles(), &messages, output);
    if let Some(page) = page {
        page.stop();
    }
    running.stop();
    let text = sensors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    output.result(out, &LiveSummary { sensors }, &text)
}

impl PageArgs {
    fn start(
        self,
        running: &Running,
        messages: fingervision_pipeline::Subscription,
        output: OutputArgs,
    ) -> Result<Option<Page>, Failure> {
        if self.no_page {
            return Ok(None);
        }
        let default = PageOptions::default();
        let options = PageOptions { address: self.bind.unwrap_or(default.address), port: self.port };
        let page = Page::start(options, running.handles(), messages, Arc::new(LiveActions))?;
        output.note(&format!("the page: {}", page.url()));
        Ok(Some(page))
    }
}

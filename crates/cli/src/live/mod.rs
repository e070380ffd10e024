//! `fingervision live`: sensors that run, on a page and in the terminal.

mod actions;
mod browser;
mod sensors;
mod status;

use std::io::Write;
use std::net::IpAddr;
use std::sync::Arc;

use fingervision_page::{Page, PageOptions};
use fingervision_pipeline::{Interest, Pipeline, Running, Sensor, Subscription};
use serde::Serialize;

use crate::failure::Failure;
use crate::output::OutputArgs;
use actions::LiveActions;
use sensors::SensorArgs;
pub(crate) use sensors::fields;
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
    /// Track without a page
    #[arg(long, conflicts_with_all = ["port", "bind", "open"])]
    no_page: bool,
    /// Open the page in the browser
    #[arg(long)]
    open: bool,
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
}

#[derive(Debug, Serialize)]
struct LiveSummary {
    sensors: Vec<SensorSummary>,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let sensors = args.sensors.open(args.output)?;
    let page = (!args.no_page).then_some(args.page);
    run_sensors(sensors, page, args.open, args.output, out)
}

/// Runs until all sensors have ended or the user stops it, with a page if one is given.
pub(crate) fn run_sensors(
    sensors: Vec<Sensor>,
    page: Option<PageArgs>,
    opens_browser: bool,
    output: OutputArgs,
    out: &mut impl Write,
) -> Result<(), Failure> {
    let pipeline = Pipeline::prepare(sensors);
    let messages = pipeline.subscribe(Interest::readings());
    let page_messages = pipeline.subscribe(Interest { capacity: PAGE_MESSAGES, ..Interest::readings() });
    let running = pipeline.start()?;
    let page = page.map(|page| page.start(&running, page_messages)).transpose()?;
    if let Some(page) = &page {
        output.note(&format!("the page: {}", page.url()));
        if opens_browser && !browser::open(&page.url()) {
            output.note("no browser was found; open this address in one");
        }
    }
    let sensors = status::show(running.handles(), &messages, output);
    if let Some(page) = page {
        page.stop();
    }
    running.stop();
    let text = sensors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    output.result(out, &LiveSummary { sensors }, &text)
}

impl PageArgs {
    /// Serves the page of sensors that run.
    pub(crate) fn start(self, running: &Running, messages: Subscription) -> Result<Page, Failure> {
        let default = PageOptions::default();
        let options = PageOptions { address: self.bind.unwrap_or(default.address), port: self.port };
        Ok(Page::start(options, running.handles(), messages, Arc::new(LiveActions))?)
    }
}

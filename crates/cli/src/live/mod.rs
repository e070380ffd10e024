//! `fingervision live`: shows live sensors on a page and in the terminal.

mod actions;
mod browser;
mod foxglove;
pub(crate) mod sensors;
pub(crate) mod status;

use std::io::Write;
use std::net::IpAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use fingervision_page::{Actions, Page, PageOptions};
use fingervision_pipeline::{Interest, Pace, Pipeline, Running, Sensor, Subscription};
use serde::Serialize;

use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::OutputArgs;
use crate::recording_file::refuse_other_names;
use crate::threads;
pub(crate) use actions::LiveActions;
use sensors::SensorArgs;
pub(crate) use sensors::fields;
use status::SensorSummary;

/// Messages that may wait for the page.
const PAGE_MESSAGES: usize = 512;
/// Interval at which it is tested, after the end of the sources, whether a browser shows the page.
const POLL: Duration = Duration::from_millis(100);
/// A page that stays closed for this time is not being loaded again.
const RELOAD: Duration = Duration::from_secs(3);

/// Track sensors live, and show depth, contact and force on a web page
///
/// The address of the page is printed. Ctrl-C ends the command. The page's record button records all sensors to a file
/// in the current folder, recording-DATE-TIME.mcap.
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
    /// Record all sensors from the start, as `fingervision record` does
    #[arg(long, value_name = "FILE.mcap")]
    record: Option<PathBuf>,
    /// Serve the sensors to Foxglove at this port of this machine, without a number at 8765
    ///
    /// Only in programs that were built with `--features foxglove`.
    #[arg(long, value_name = "PORT", num_args = 0..=1, require_equals = true, default_missing_value = "8765")]
    #[arg(value_parser = foxglove::port)]
    foxglove: Option<u16>,
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

/// The outputs besides the line in the terminal: the page and a recording.
#[derive(Debug, Default)]
pub(crate) struct Show {
    pub(crate) page: Option<PageArgs>,
    pub(crate) opens_browser: bool,
    pub(crate) record: Option<PathBuf>,
    /// The port of the server for Foxglove.
    pub(crate) foxglove: Option<u16>,
}

#[derive(Debug, Serialize)]
struct LiveSummary {
    sensors: Vec<SensorSummary>,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    if let Some(file) = &args.record {
        refuse_other_names(file, false)?;
    }
    let page = (!args.no_page).then_some(args.page);
    page.map_or(Ok(()), PageArgs::check)?;
    args.foxglove.map_or(Ok(()), foxglove::check)?;
    let sensors = args.sensors.open(Pace::Recorded, args.output)?;
    let show = Show { page, opens_browser: args.open, record: args.record.clone(), foxglove: args.foxglove };
    run_sensors(sensors, &show, args.output, out)
}

/// Runs until all sensors have ended or the user stops the command.
pub(crate) fn run_sensors(
    sensors: Vec<Sensor>,
    show: &Show,
    output: OutputArgs,
    out: &mut impl Write,
) -> Result<(), Failure> {
    let pipeline = Pipeline::prepare(sensors).with_workers(threads::count());
    let messages = pipeline.subscribe(Interest::readings());
    let page_messages = pipeline.subscribe(Interest { capacity: PAGE_MESSAGES, ..Interest::readings() });
    let running = pipeline.start()?;
    let actions = Arc::new(LiveActions::new(running.handles(), running.subscriptions()));
    if let Some(file) = &show.record {
        actions.record(file)?;
    }
    let page = show.page.map(|page| page.start(&running, page_messages, actions.clone())).transpose()?;
    if let Some(page) = &page {
        output.note(&format!("the page: {}", page.url()));
        if show.opens_browser && !browser::open(&page.url()) {
            output.note("no browser was found; open this address in one");
        }
    }
    let sensors = {
        // Ends after the block, with its thread.
        let foxglove = show.foxglove.map(|port| foxglove::start(port, &running)).transpose()?;
        if let Some(server) = &foxglove {
            output.note(&format!("Foxglove: open the connection {}", server.url()));
        }
        status::show(running.handles(), &messages, actions.as_ref(), output)
    };
    if let Some(page) = page {
        keep_open(&page, output);
        page.stop();
    }
    running.stop();
    if let Some(text) = actions.close() {
        output.note(&text);
    }
    let text = sensors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    output.result(out, &LiveSummary { sensors }, &text)
}

/// Lets the user look at the last values: waits until no browser shows the page, or Ctrl-C.
fn keep_open(page: &Page, output: OutputArgs) {
    let interrupt = Interrupt::listen();
    if !page.is_open() || interrupt.is_asked() {
        return;
    }
    output.note("the sources have ended; close the page, or press Ctrl-C, to end the command");
    let mut closed = Duration::ZERO;
    // A page that is loaded again is closed for a moment.
    while closed < RELOAD && !interrupt.is_asked() {
        std::thread::sleep(POLL);
        closed = if page.is_open() { Duration::ZERO } else { closed + POLL };
    }
}

impl PageArgs {
    fn options(self) -> PageOptions {
        let default = PageOptions::default();
        PageOptions { address: self.bind.unwrap_or(default.address), port: self.port }
    }

    /// Refuses an address at which no page can be served, before work that takes long.
    pub(crate) fn check(self) -> Result<(), Failure> {
        Ok(Page::check(self.options())?)
    }

    /// Serves the page of running sensors.
    pub(crate) fn start(
        self,
        running: &Running,
        messages: Subscription,
        actions: Arc<dyn Actions>,
    ) -> Result<Page, Failure> {
        Ok(Page::start(self.options(), running.handles(), messages, actions)?)
    }
}

//! `fingervision demo`: tracks simulated presses, without any hardware.

mod folder;
mod page;

use std::io::Write;
use std::path::PathBuf;

use crate::failure::Failure;
use crate::live::PageArgs;
use crate::output::OutputArgs;

/// The ready-made scene that is shown first.
const SCENE: &str = "letter";

/// Press letters and other objects into a simulated gel, and show the measurement on a web page
///
/// No hardware is needed. The page opens in the browser; Ctrl-C ends the demo. The first press takes some seconds to
/// solve; its solution is kept for the next time.
///
/// With `--headless` one press is written to a folder instead: `simulation` (the files of simulate), `run` (those of
/// track) and `run/evaluation` (those of evaluate).
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Write one press and its evaluation to a folder, without a page
    #[arg(long)]
    headless: bool,
    /// The folder to write, as with --headless; without it ./fingervision-demo, where an earlier demo is replaced
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace an earlier demo in the folder of --out
    #[arg(long, requires = "out")]
    overwrite: bool,
    /// Print the address of the page, but do not open a browser
    #[arg(long, conflicts_with_all = ["headless", "out"])]
    no_browser: bool,
    #[command(flatten)]
    page: PageArgs,
    #[command(flatten)]
    output: OutputArgs,
}

impl Args {
    /// Whether an earlier demo in the folder is replaced.
    fn overwrites(&self) -> bool {
        self.overwrite || self.out.is_none()
    }
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let is_folder = args.headless || args.out.is_some();
    if is_folder { folder::run(args, out) } else { page::run(args, out) }
}

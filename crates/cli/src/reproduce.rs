//! `fingervision reproduce`: the paper's tables and figures.

use std::io::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use fingervision_evaluate::paper::{Extent, Reproduction, reproduce};
use fingervision_gel::PressCache;
use serde::Serialize;

use crate::failure::Failure;
use crate::output::OutputArgs;
use crate::report_folder::ReportFolder;

/// The folder of a reproduction if none is given.
const FOLDER: &str = "fingervision-reproduction";

/// Reproduce the tables and figures of Du et al. 2021 on one page, beside the paper's numbers
///
/// Simulated presses are rendered, tracked and calibrated, then compared with their exact truth, in the paper's own
/// setting and on the default sensor. Solved presses are kept, so a second call is faster. The folder will contain
/// report.html, with all pictures, and report.json with every number.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The folder to write: new, empty, or with --overwrite an earlier report; without it ./fingervision-reproduction,
    /// where an earlier report is replaced
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// One sensor, draft meshes, two indenters, half as many frames: a quick test
    #[arg(long)]
    quick: bool,
    /// Solve every press again, and do not keep the solutions
    #[arg(long)]
    no_cache: bool,
    /// Replace an earlier report in the folder
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    output: OutputArgs,
}

#[derive(Debug, Serialize)]
struct ReproduceResult {
    #[serde(flatten)]
    reproduction: Reproduction,
    page: PathBuf,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let folder =
        ReportFolder::create(args.out.as_deref().unwrap_or(Path::new(FOLDER)), args.overwrite || args.out.is_none())?;
    let extent = if args.quick { Extent::Quick } else { Extent::Full };
    let cache = if args.no_cache { PressCache::OFF } else { PressCache::standard() };
    let bar = args.output.steps("reproducing", extent.parts());
    let progress = |part: &str| {
        bar.set_message(part.to_owned());
        bar.inc(1);
        ControlFlow::Continue(())
    };
    let reproduction = reproduce(extent, &cache, &progress)?;
    bar.finish_and_clear();
    let page = folder.write(&reproduction, &reproduction.page())?;
    let text = format!("{reproduction}page          {}", page.display());
    args.output.result(out, &ReproduceResult { reproduction, page }, &text)
}

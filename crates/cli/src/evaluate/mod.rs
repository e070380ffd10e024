//! `fingervision evaluate`: errors of a run against the truth.

mod benchmark;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use fingervision_evaluate::run::{Evaluation, Options, Outcome, Report};
use fingervision_sink::{SinkError, write_png};
use serde::Serialize;

use crate::failure::Failure;
use crate::output::{OutputArgs, refuse_existing};
use benchmark::BenchmarkArgs;

/// The picture's name in its folder.
const PICTURE: &str = "evaluation.png";
/// The picture's folder in the folder of a run.
pub(crate) const FOLDER: &str = "evaluation";

/// Compare a run with its truth: errors of flow, depth and force, as a table and a picture
///
/// Depth and flow are compared where the truth is visible and the run is valid, everywhere and in three regions: inside
/// the true contact, within 1 mm of its border on both sides (its inner half is also inside), and outside of both.
/// Distances are measured on the undeformed gel. If a run contains its own validity of depth (`depth_valid.npy`, from
/// elasticity), depth, displacement and contact are compared where that is 1, and depth a second time where the flow is
/// also valid. Any program that writes flow.npy [frames, rows, columns, 2], in px, or depth.npy [frames, rows,
/// columns], in mm, can be compared; valid.npy, run.toml and readings.csv may be absent.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The folder that `track --out` wrote, or any other folder with such arrays
    #[arg(required_unless_present = "benchmark", conflicts_with = "benchmark")]
    run: Option<PathBuf>,
    /// The folder that `simulate --out` wrote, or its subfolder `truth`
    #[arg(required_unless_present = "benchmark")]
    truth: Option<PathBuf>,
    /// Instead, compare methods for depth over all ready-made scenes, with seven variations of the sensor and of
    /// friction
    ///
    /// Every scene is solved, rendered and tracked; every method that needs calibration gets the nine calibration
    /// presses of the same sensor. The folder will contain report.html, report.json and the scenes in cases/.
    #[arg(long)]
    benchmark: bool,
    #[command(flatten)]
    of_benchmark: BenchmarkArgs,
    /// The folder for evaluation.png, or for the benchmark's report; without it RUN/evaluation or
    /// ./fingervision-benchmark, where an earlier one is replaced
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// If the run was interrupted, compare only the first frames, which all files contain
    #[arg(long, conflicts_with = "benchmark")]
    common_frames: bool,
    /// Replace an earlier evaluation.png or report in the folder of --out
    #[arg(long, requires = "out")]
    overwrite: bool,
    #[command(flatten)]
    output: OutputArgs,
}

#[derive(Debug, Serialize)]
struct EvaluateResult {
    #[serde(flatten)]
    report: Report,
    picture: PathBuf,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let (Some(run), Some(truth)) = (&args.run, &args.truth) else {
        return benchmark::benchmark(&args.of_benchmark, args.out.as_deref(), args.overwrite, args.output, out);
    };
    let folder = args.out.clone().unwrap_or_else(|| run.join(FOLDER));
    if args.out.is_some() && !args.overwrite {
        refuse_existing(&folder.join(PICTURE))?;
    }
    let options = Options { common_frames: args.common_frames };
    let (report, picture) = compare([run, truth], &folder, options, args.output)?;
    let text = format!("{report}picture   {}", picture.display());
    args.output.result(out, &EvaluateResult { report, picture }, &text)
}

/// Compares a run with a truth and draws the picture into `folder`; returns the report and the picture's path.
///
/// # Errors
///
/// Why the two cannot be compared, or the picture cannot be written.
pub(crate) fn compare(
    [run, truth]: [&Path; 2],
    folder: &Path,
    options: Options,
    output: OutputArgs,
) -> Result<(Report, PathBuf), Failure> {
    let mut evaluation = Evaluation::open(run, truth, options)?;
    let progress = output.progress("comparing", Some(evaluation.frame_count()));
    while evaluation.advance()? {
        progress.inc(1);
    }
    progress.finish_and_clear();
    let (outcome, picture) = (evaluation.finish(), folder.join(PICTURE));
    write_picture(&outcome, &picture)?;
    Ok((outcome.report, picture))
}

fn write_picture(outcome: &Outcome, path: &Path) -> Result<(), SinkError> {
    let refused = |error| SinkError::Write { path: path.to_owned(), error };
    path.parent().map_or(Ok(()), fs::create_dir_all).map_err(refused)?;
    write_png(&outcome.draw(), path)
}

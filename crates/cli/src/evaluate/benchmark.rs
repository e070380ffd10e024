//! `fingervision evaluate --benchmark`: compares methods for depth with the exact truth, over all ready-made scenes.

use std::io::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use fingervision_evaluate::benchmark::{Benchmark, BenchmarkReport, Case, Entry, Extent, cases, run};
use fingervision_gel::{PressCache, Resolution};
use serde::Serialize;

use crate::failure::Failure;
use crate::output::OutputArgs;
use crate::profile_args::assignment;
use crate::report_folder::ReportFolder;

/// The folder of a benchmark if none is given.
const FOLDER: &str = "fingervision-benchmark";

/// The value of `--entry`.
fn entry(text: &str) -> Result<Entry, String> {
    match text.split_once('=') {
        Some((name, folder)) if !name.trim().is_empty() && !folder.is_empty() => {
            Ok(Entry { name: name.trim().into(), folder: folder.into() })
        }
        _ => Err("expected NAME=FOLDER".into()),
    }
}

/// The mesh on which scenes are solved.
#[derive(Debug, Clone, Copy, Default, clap::ValueEnum)]
pub(super) enum Mesh {
    /// 0.75 mm where the gel is touched: seconds per press
    #[default]
    Draft,
    /// 0.45 mm: a minute
    Medium,
    /// 0.3 mm: minutes
    Fine,
}

impl From<Mesh> for Resolution {
    fn from(mesh: Mesh) -> Self {
        match mesh {
            Mesh::Draft => Self::Draft,
            Mesh::Medium => Self::Medium,
            Mesh::Fine => Self::Fine,
        }
    }
}

/// The options of the benchmark.
#[derive(Debug, clap::Args)]
pub(super) struct BenchmarkArgs {
    /// Evaluate another program too: FOLDER/CASE/depth.npy for each scene in cases/; may be repeated
    #[arg(long = "entry", value_name = "NAME=FOLDER", conflicts_with = "run", value_parser = entry)]
    entries: Vec<Entry>,
    /// Give the tracker a value that differs from the simulated sensor, as in `elastic.network=false`; may be repeated
    ///
    /// Any key of a profile can be given. This shows the effect of a wrong value, or the contribution of a part of the
    /// tracker.
    #[arg(long = "set", value_name = "KEY=VALUE", conflicts_with = "run", value_parser = assignment)]
    assignments: Vec<(String, String)>,
    /// Solve the scenes on this mesh; calibration presses use the draft mesh
    #[arg(long, value_enum, value_name = "MESH", conflicts_with = "run", default_value_t)]
    mesh: Mesh,
    /// Only three scenes on the default sensor, as a quick test
    #[arg(long, conflicts_with = "run")]
    quick: bool,
}

#[derive(Debug, Serialize)]
struct BenchmarkResult {
    #[serde(flatten)]
    report: BenchmarkReport,
    page: PathBuf,
}

/// Runs it into a folder, or into `./fingervision-benchmark`.
pub(super) fn benchmark(
    args: &BenchmarkArgs,
    folder: Option<&Path>,
    overwrite: bool,
    output: OutputArgs,
    out: &mut impl Write,
) -> Result<(), Failure> {
    let extent = if args.quick { Extent::Quick } else { Extent::Full };
    let cases = cases(extent, args.mesh.into())?;
    let cache = PressCache::standard();
    let BenchmarkArgs { entries, assignments, .. } = args;
    let benchmark = Benchmark { extent, cases: cases.clone(), assignments, entries, cache: &cache };
    // An earlier report is kept if this one cannot begin.
    benchmark.check()?;
    let folder = ReportFolder::create(folder.unwrap_or(Path::new(FOLDER)), overwrite || folder.is_none())?;
    write_cases(&folder, &cases)?;
    let bar = output.steps("benchmark", cases.len() as u64);
    let progress = |name: &str| {
        if cases.iter().any(|case| case.name == name) {
            bar.inc(1);
        }
        bar.set_message(name.to_owned());
        ControlFlow::Continue(())
    };
    let report = run(&benchmark, &progress)?;
    bar.finish_and_clear();
    let page = folder.write(&report, &report.page())?;
    let text = format!("{report}page      {}", page.display());
    output.result(out, &BenchmarkResult { report, page }, &text)
}

/// Writes the scenes for other programs that take part.
fn write_cases(folder: &ReportFolder, cases: &[Case]) -> Result<(), Failure> {
    cases.iter().try_for_each(|case| folder.add(&format!("cases/{}.toml", case.name), case.scene.to_toml().as_bytes()))
}

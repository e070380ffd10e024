//! `fingervision evaluate --benchmark`: ways to depth against exact truth, over all ready-made scenes.

use std::io::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use fingervision_evaluate::benchmark::{Benchmark, BenchmarkReport, Case, Entry, Extent, cases, run};
use fingervision_gel::PressCache;
use serde::Serialize;

use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::OutputArgs;
use crate::report_folder::ReportFolder;

/// The folder of a benchmark that was not given one.
const FOLDER: &str = "fingervision-benchmark";

/// What `--entry` takes.
pub(super) fn entry(text: &str) -> Result<Entry, String> {
    match text.split_once('=') {
        Some((name, folder)) if !name.trim().is_empty() && !folder.is_empty() => {
            Ok(Entry { name: name.trim().into(), folder: folder.into() })
        }
        _ => Err("it takes NAME=FOLDER".into()),
    }
}

#[derive(Debug, Serialize)]
struct BenchmarkResult {
    #[serde(flatten)]
    report: BenchmarkReport,
    page: PathBuf,
}

/// Runs it into a folder, or into `./fingervision-benchmark`.
pub(super) fn benchmark(
    folder: Option<&Path>,
    extent: Extent,
    entries: &[Entry],
    output: OutputArgs,
    out: &mut impl Write,
) -> Result<(), Failure> {
    let interrupt = Interrupt::listen()?;
    let folder = ReportFolder::create(folder.unwrap_or(Path::new(FOLDER)))?;
    let cases = cases(extent)?;
    write_cases(&folder, &cases)?;
    let bar = output.steps("benchmark", cases.len() as u64);
    let progress = |name: &str| {
        if cases.iter().any(|case| case.name == name) {
            bar.inc(1);
        }
        bar.set_message(name.to_owned());
        if interrupt.is_asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let cache = PressCache::standard();
    let report = run(&Benchmark { extent, cases: cases.clone(), entries, cache: &cache }, &progress)?;
    bar.finish_and_clear();
    let page = folder.write(&report, &report.page())?;
    let text = format!("{report}page      {}", page.display());
    output.result(out, &BenchmarkResult { report, page }, &text)
}

/// The scenes, for other programs to take part.
fn write_cases(folder: &ReportFolder, cases: &[Case]) -> Result<(), Failure> {
    cases.iter().try_for_each(|case| folder.add(&format!("cases/{}.toml", case.name), case.scene.to_toml().as_bytes()))
}

//! `cargo xtask instructions`: counts the instructions of a frame, and compares them with a committed record.
//!
//! Times on a shared machine differ by a quarter from run to run; instruction counts differ by less than one per cent.
//! The frames are a simulated press with fixed noise ([`film`]). Each stage runs under valgrind ([`valgrind`]), which
//! emulates AVX2 at most. The record has the error of each stage beside its count, because fewer instructions with a
//! larger error are no progress.

mod film;
mod record;
mod stage;
mod valgrind;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Result, bail, ensure};
use fearless_simd::Level;
use fingervision_evaluate::{end_point_errors, mean, without_border};
use fingervision_flow::FlowField;
use fingervision_gel::Truth;
use fingervision_image::{Image, Pixels, Rect, grey_into};
use fingervision_touch::Reading;

use film::Film;
pub(crate) use record::{Entry, Record, millions};
pub(crate) use stage::Stage;
use stage::{Output, Run};
use valgrind::{Counts, LINE_BYTES};

/// Border that is left out of the error of the flow, px.
const BORDER_PX: usize = 16;

/// Options of the count.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Fail instead of skipping where valgrind or the record is missing, or the record is of another compiler.
    #[arg(long)]
    required: bool,
    /// Write the record instead of comparing with it.
    #[arg(long)]
    update: bool,
    /// Also record the bytes that move between the caches: takes twice as long.
    #[arg(long, requires = "update")]
    caches: bool,
    /// Process the frames of this file; the counted program is started with it.
    #[arg(long, hide = true, requires = "film")]
    count: Option<Run>,
    #[arg(long, hide = true)]
    film: Option<PathBuf>,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<()> {
    let build = Build::of(&std::env::current_exe()?);
    if let (Some(run), Some(film)) = (args.count, &args.film) {
        return run.play(&Film::read(film, build.size())?, |_, _, _| {});
    }
    let valgrind = match valgrind::version() {
        Ok(version) => version,
        Err(why) if !args.required => {
            writeln!(out, "instructions: skipped, {why:#}")?;
            return Ok(());
        }
        Err(why) => return Err(why),
    };
    let (path, rustc) = (record_of(build), rustc()?);
    let record = if args.update { None } else { read_record(build, &rustc, args.required, out)? };
    if record.is_none() && !args.update {
        return Ok(());
    }
    let start = Instant::now();
    let stages = measure(build.size(), args.caches)?;
    let seconds = start.elapsed().as_secs_f64();
    let Some(record) = record else {
        let instruction_set = instruction_set();
        let (processor, size) = (processor(), build.size().into());
        for entry in &stages {
            writeln!(out, "{entry}")?;
        }
        Record { instruction_set, processor, rustc, valgrind, size, stages }.write(&path)?;
        writeln!(out, "instructions: wrote {}, counted in {seconds:.0} s", path.display())?;
        return Ok(());
    };
    let comparison = record.compare(&stages);
    for line in &comparison.lines {
        writeln!(out, "{line}")?;
    }
    if !comparison.faults.is_empty() {
        bail!("{}; if it is intended: {}", comparison.faults.join("; "), build.update());
    }
    if comparison.fallen > 0 {
        writeln!(out, "{} stages take less than recorded: {}", comparison.fallen, build.update())?;
    }
    writeln!(out, "instructions: {} stages as recorded, counted in {seconds:.0} s", stages.len())?;
    Ok(())
}

/// The record of this instruction set, or nothing and a line that says why.
fn read_record(build: Build, rustc: &str, is_required: bool, out: &mut impl Write) -> Result<Option<Record>> {
    let path = record_of(build);
    let fault = if path.is_file() {
        let record = Record::read(&path)?;
        if record.rustc == rustc {
            return Ok(Some(record));
        }
        format!("{} is of {}, and this is {rustc}", path.display(), record.rustc)
    } else {
        format!("{} does not exist", path.display())
    };
    ensure!(!is_required, "{fault}: {}", build.update());
    writeln!(out, "instructions: skipped, {fault}")?;
    Ok(None)
}

/// Renders the film, then counts and evaluates every stage.
fn measure(size: (usize, usize), with_caches: bool) -> Result<Vec<Entry>> {
    let (film, truths) = Film::make(size)?;
    let folder = crate::target_folder().join("instructions");
    fs::create_dir_all(&folder)?;
    let path = folder.join(format!("{}.rgb", std::process::id()));
    film.write(&path)?;
    let counted = valgrind::count_all(&path, with_caches);
    fs::remove_file(&path)?;
    let counted = counted?;
    let mut errors = Vec::new();
    for run in Run::ALL {
        run.play(&film, |stage, number, output| {
            errors.push((stage, error(stage, output, film.frame(number), &truths[number])));
        })?;
    }
    Ok(counted.into_iter().map(|(stage, counts)| entry(stage, counts, with_caches, &errors)).collect())
}

fn entry(stage: Stage, counts: Counts, with_caches: bool, errors: &[(Stage, f64)]) -> Entry {
    let of_stage = errors.iter().filter(|(of, _)| *of == stage).map(|(_, error)| *error as f32);
    // A reference has nothing to err in.
    let error = (stage != Stage::Reference).then(|| mean(of_stage));
    let bytes = |lines: u64| with_caches.then_some(lines * LINE_BYTES);
    Entry {
        stage,
        instructions: counts.instructions,
        first_cache_bytes: bytes(counts.first_misses),
        second_cache_bytes: bytes(counts.second_misses),
        error,
        unit: error.map(|_| unit(stage).to_owned()),
    }
}

fn unit(stage: Stage) -> &'static str {
    match stage {
        Stage::RestLive | Stage::RestExact | Stage::Live | Stage::Exact => "mm",
        Stage::Jpeg => "levels",
        _ => "px",
    }
}

/// Mean error of a frame: of depth in contact, at rest everywhere; of the flow; of the decoded pixels.
fn error(stage: Stage, output: Output, frame: &Image<[u8; 3]>, truth: &Truth) -> f64 {
    let (width, height) = frame.size();
    match output {
        Output::Reading(Reading { depth: Some(depth), .. }) if unit(stage) == "mm" => {
            let touched = truth.contact.values();
            let pairs = depth.values().iter().zip(truth.depth.values()).enumerate();
            let is_at_rest = stage.base() == Some(Stage::Rest);
            let counted = pairs.filter(|&(place, _)| is_at_rest || touched[place] == 1);
            mean(counted.map(|(_, (is_mm, true_mm))| (is_mm - true_mm).abs()).filter(|error| error.is_finite()))
        }
        Output::Reading(reading) => {
            let [u, v] = [0, 1].map(|part| Image::from_fn(width, height, |x, y| truth.flow.at(x, y)[part]));
            let (truth, region) = (FlowField { u, v }, without_border((width, height), BORDER_PX));
            mean(end_point_errors(&reading.flow, &truth, region).filter(|error| error.is_finite()))
        }
        Output::Picture(decoded) => {
            let [is, was] = [decoded, &Pixels::Rgb8(frame.clone())].map(|pixels| {
                let mut grey = Image::from_fn(width, height, |_, _| f32::NAN);
                grey_into(pixels, Rect::whole(width, height), &mut grey).map(|()| grey)
            });
            match (is, was) {
                (Ok(is), Ok(was)) => mean(is.values().iter().zip(was.values()).map(|(is, was)| (is - was).abs())),
                _ => f64::NAN,
            }
        }
    }
}

/// The record for the instruction set that valgrind offers, of the optimised build.
pub(crate) fn record_path() -> PathBuf {
    record_of(Build::Optimised)
}

fn record_of(build: Build) -> PathBuf {
    let build = match build {
        Build::Optimised => "",
        Build::Tests => "-tests",
    };
    let name = format!("{}{build}.json", instruction_set().to_lowercase());
    crate::workspace().join("benches/instructions").join(name)
}

/// How this program was built. Checks for overflow in the tests' build take instructions of their own, so it has its own record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Build {
    /// By `cargo xtask`.
    Optimised,
    /// Together with the tests.
    Tests,
}

impl Build {
    /// By the folder that this program is in.
    fn of(program: &Path) -> Self {
        let folder = program.parent().and_then(Path::file_name);
        if folder.is_some_and(|folder| folder == "debug") { Self::Tests } else { Self::Optimised }
    }

    /// Columns and rows of the frames, px. Those of the tests' build have a quarter of the pixels, because every change is counted.
    fn size(self) -> (usize, usize) {
        match self {
            Self::Optimised => (640, 480),
            Self::Tests => (320, 240),
        }
    }

    /// The command that writes its record.
    fn update(self) -> &'static str {
        match self {
            Self::Optimised => "cargo xtask instructions --update",
            Self::Tests => "target/debug/xtask instructions --update",
        }
    }
}

/// The highest instruction set that both the processor and valgrind know.
fn instruction_set() -> String {
    name_of(counted_level())
}

/// The highest instruction set of the processor that the kernels use.
pub(crate) fn instruction_set_of_processor() -> String {
    name_of(Level::new())
}

fn name_of(level: Level) -> String {
    let name = format!("{level:?}");
    name.split(['(', ' ']).next().unwrap_or_default().replace('_', ".").to_uppercase()
}

#[cfg(target_arch = "x86_64")]
fn counted_level() -> Level {
    Level::new().as_avx2().map_or_else(Level::new, Level::Avx2)
}

#[cfg(not(target_arch = "x86_64"))]
fn counted_level() -> Level {
    Level::new()
}

fn rustc() -> Result<String> {
    let output = crate::expect_success(Command::new("rustc").arg("--version"))?;
    Ok(String::from_utf8_lossy(&output).trim().to_owned())
}

/// Name, family and model of the processor, if the system reports them.
pub(crate) fn processor() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let value = |name: &str| {
        let mut pairs = text.lines().filter_map(|line| line.split_once(':'));
        pairs.find(|(key, _)| key.trim() == name).map(|(_, value)| value.trim().to_owned())
    };
    match (value("model name"), value("cpu family"), value("model")) {
        (Some(name), Some(family), Some(model)) => format!("{name}, family {family}, model {model}"),
        _ => std::env::consts::ARCH.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_build_is_known_by_its_folder_and_has_a_record_of_its_own() {
        let builds =
            ["target/debug/xtask", "target/release/xtask", "elsewhere/profiling/xtask", "xtask"].map(Path::new);
        assert_eq!(builds.map(Build::of), [Build::Tests, Build::Optimised, Build::Optimised, Build::Optimised]);
        assert_ne!(record_of(Build::Tests), record_of(Build::Optimised));
        assert_ne!(Build::Tests.update(), Build::Optimised.update());
    }
}

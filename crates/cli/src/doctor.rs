//! `fingervision doctor`: the capabilities of this machine.

mod cameras;

use std::fmt;
use std::io::Write;
use std::num::NonZero;
use std::path::PathBuf;
use std::thread::available_parallelism;
use std::time::Instant;

use fearless_simd::Level;
use fingervision_gel::{CacheSize, PressCache};
use fingervision_touch::{Fields, Profile, Tracker};
use serde::Serialize;

use cameras::CameraReport;

use crate::failure::Failure;
use crate::output::OutputArgs;
use crate::simulated_press::SimulatedPress;
use crate::truth::frame_error;

/// Columns and rows of the self-test's images, px.
const SIZE: (usize, usize) = (320, 240);
const RADIUS_PX: f64 = 50.0;
const AMPLITUDE_PX: f64 = 3.0;
/// The self-test fails above this mean end-point error, px: several times the error caused by noise.
const LARGEST_ERROR_PX: f64 = 0.05;

const READS: [&str; 6] = [
    "folders of PNG, JPEG, TIFF and BMP images, 8 and 16 bit, grey and colour",
    "H.264 video in MP4 and MOV",
    "motion JPEG video in AVI, MP4 and MOV",
    "recordings of fingervision record, MCAP",
    "cameras on Linux, camera:ID",
    "simulated scenes, sim:NAME",
];
const NOT_READ: &str = "H.265, VP9 and AV1 video, Matroska and WebM files";

/// Show this machine's capabilities and cameras, and test it on a simulated touch
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    output: OutputArgs,
}

#[derive(Debug, Serialize)]
struct Diagnosis {
    version: &'static str,
    cores: usize,
    instruction_set: String,
    reads: [&'static str; 6],
    cache: CacheState,
    #[serde(flatten)]
    cameras: CameraReport,
    self_test_error_px: f64,
    self_test_valid: f64,
    self_test_ms: f64,
}

/// The cache of solved presses.
#[derive(Debug, Serialize)]
struct CacheState {
    /// Absent if this machine has no place for it.
    folder: Option<PathBuf>,
    presses: usize,
    bytes: u64,
}

impl CacheState {
    fn new(cache: &PressCache) -> Self {
        let CacheSize { entries, bytes } = cache.size();
        Self { folder: cache.folder().map(Into::into), presses: entries, bytes }
    }
}

impl fmt::Display for CacheState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.folder {
            Some(folder) => {
                let (presses, megabytes) = (self.presses, self.bytes as f64 / 1e6);
                write!(f, "{presses} solved presses, {megabytes:.1} MB, in {}", folder.display())
            }
            None => f.write_str("none: no cache folder was found; FINGERVISION_CACHE sets one"),
        }
    }
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let diagnosis = Diagnosis::new()?;
    args.output.result(out, &diagnosis, &diagnosis.to_string())?;
    if diagnosis.is_healthy() {
        return Ok(());
    }
    let (error, valid) = (diagnosis.self_test_error_px, 100.0 * diagnosis.self_test_valid);
    Err(Failure::new(
        format!("the self-test's flow has an error of {error:.3} px, and {valid:.0} % of it are valid"),
        format!(
            "the program does not work correctly on this machine: expected at most {LARGEST_ERROR_PX} px and 80 %; please report it"
        ),
    ))
}

impl Diagnosis {
    /// Inspects the machine and tracks a touch whose truth is known.
    fn new() -> Result<Self, Failure> {
        // The middle one of three frames is the deepest.
        let touch = SimulatedPress::new(SIZE, RADIUS_PX, AMPLITUDE_PX, 3)?;
        let (rest, touched) = (touch.frame(0)?, touch.frame(1)?);
        let mut tracker = Tracker::new(&Profile::default(), SIZE, true, Fields::default())?;
        tracker.track(&rest)?;
        let arrival = Instant::now();
        let reading = tracker.track(&touched)?;
        let self_test_ms = 1e3 * arrival.elapsed().as_secs_f64();
        let error = frame_error(reading, &touch.press().motion(1));
        Ok(Self {
            version: env!("CARGO_PKG_VERSION"),
            cores: available_parallelism().map_or(1, NonZero::get),
            instruction_set: instruction_set(Level::new()),
            reads: READS,
            cache: CacheState::new(&PressCache::standard()),
            cameras: CameraReport::find(),
            self_test_error_px: error.mean_px,
            self_test_valid: error.valid,
            self_test_ms,
        })
    }

    fn is_healthy(&self) -> bool {
        self.self_test_error_px <= LARGEST_ERROR_PX && self.self_test_valid >= 0.8
    }
}

/// The name of the instruction set that kernels use.
pub(crate) fn instruction_set(level: Level) -> String {
    let name = format!("{level:?}");
    name.split(['(', ' ']).next().unwrap_or_default().replace('_', ".").to_uppercase()
}

impl fmt::Display for Diagnosis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { version, cores, instruction_set, self_test_error_px, self_test_ms, .. } = self;
        let (width, height) = SIZE;
        writeln!(f, "fingervision {version}")?;
        writeln!(f, "machine    {cores} cores, {instruction_set} instructions")?;
        let verdict = if self.is_healthy() { "passed" } else { "FAILED" };
        write!(f, "self-test  {verdict}: the flow of a simulated touch of {AMPLITUDE_PX} px has an error of ")?;
        writeln!(f, "{self_test_error_px:.3} px on average; {self_test_ms:.1} ms for {width}x{height} px")?;
        for (k, kind) in self.reads.iter().enumerate() {
            writeln!(f, "{:10} {kind}", if k == 0 { "reads" } else { "" })?;
        }
        writeln!(f, "not read   {NOT_READ}")?;
        writeln!(f, "cache      {}", self.cache)?;
        write!(f, "{}", self.cameras)?;
        writeln!(f, "next       fingervision demo, which needs no sensor; with one: fingervision calibrate")
    }
}

//! `cargo xtask soak`: sensors that run for long, with a page and a recording, must drop no frame, and their memory must
//! not grow.
//!
//! `fingervision live` runs with simulated presses that repeat without end, and records them. A client reads all
//! messages of the page. Every few seconds the memory of the process is read. At the end the recording is read as a
//! whole. The figures are those of an idle machine only if nothing else runs on it.

mod live;
mod memory;
mod page_client;
mod recorded;
mod report;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use fingervision_evaluate::quantile;

use live::Live;
use memory::Memory;
use page_client::{PageClient, Seen};
use report::Report;

/// Time between two samples of the memory.
const SAMPLE: Duration = Duration::from_secs(5);
/// Time between two lines on the progress.
const PROGRESS: Duration = Duration::from_mins(1);
/// Buffers and caches grow in this time, s. A shorter run warms up for a third of it.
const WARM_UP_S: f64 = 120.0;
/// Bytes of a recorded frame with its reading and its part of the surfaces.
const FRAME_BYTES: f64 = 0.9e6;

/// Options of the soak.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// How long the sensors run.
    #[arg(long, default_value_t = 30.0, value_parser = positive)]
    minutes: f64,
    /// Number of sensors.
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=16))]
    sensors: u8,
    /// Frames per second of each sensor.
    #[arg(long, default_value_t = 10.0, value_parser = positive)]
    rate: f64,
    /// What all sensors show instead of a simulated press: a camera, a video or a recording that lasts long enough.
    #[arg(long, conflicts_with = "rate")]
    source: Option<String>,
    /// The profile of all sensors; without it that of the recording or the simulated press.
    #[arg(long, value_name = "FILE")]
    profile: Option<PathBuf>,
    /// Record nothing.
    #[arg(long)]
    no_recording: bool,
    /// Number of clients that read all messages of the page, which must not slow tracking: compare 0, 1 and 5.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u8).range(..=50))]
    pages: u8,
}

/// A positive number.
fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| format!("{text} is not a positive number"))
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<()> {
    let Args { minutes, sensors, rate, .. } = *args;
    let command = crate::build_command()?;
    let folder = crate::target_folder().join("soak");
    if folder.exists() {
        fs::remove_dir_all(&folder).with_context(|| folder.display().to_string())?;
    }
    fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    let file = folder.join("soak.mcap");
    let scene = || format!("sim:letter?loop&draft&fps={rate}");
    let source = args.source.clone().unwrap_or_else(scene);
    write!(out, "soak: {sensors} sensors, {source}, for {minutes} min")?;
    if args.no_recording {
        writeln!(out)?;
    } else {
        let bytes = 60.0 * minutes * f64::from(sensors) * rate * FRAME_BYTES;
        check_space(&folder, bytes)?;
        writeln!(out, "; up to {:.1} GB", bytes / 1e9)?;
    }
    let recording = (!args.no_recording).then_some(file.as_path());
    let mut live = Live::start(&command, &vec![source; usize::from(sensors)], (args.profile.as_deref(), recording))?;
    let pages = (0..args.pages).map(|_| PageClient::open(live.host())).collect::<Result<Vec<_>>>()?;
    let (memory, rest) = watch(&mut live, &pages, Duration::from_secs_f64(60.0 * minutes), out)?;
    let seen = pages.into_iter().map(PageClient::finish).collect::<Result<Vec<_>>>()?;
    let latencies_ms: Vec<f32> = seen.into_iter().flat_map(|seen| seen.latencies_ms).collect();
    let ended = live.stop()?;
    let recorded = match recording {
        Some(file) => {
            writeln!(out, "soak: reading the recording")?;
            Some(recorded::read(file)?)
        }
        None => None,
    };
    let report = Report::new(&ended, recorded.as_deref(), &memory, rest, &latencies_ms);
    writeln!(out, "\n{}", report.table())?;
    let faults = report.faults();
    let place = recording.map(|file| format!("; the recording is {}", file.display())).unwrap_or_default();
    ensure!(faults.is_empty(), "soak: {}{place}", faults.join("; "));
    fs::remove_dir_all(&folder).with_context(|| folder.display().to_string())
}

/// Refuses to fill the disk.
fn check_space(folder: &Path, bytes: f64) -> Result<()> {
    let free = fs4::available_space(folder).with_context(|| folder.display().to_string())? as f64;
    ensure!(
        bytes < free,
        "the recording takes about {:.1} GB, but {} has {:.1} GB free; choose fewer --minutes or a lower --rate",
        bytes / 1e9,
        folder.display(),
        free / 1e9
    );
    Ok(())
}

/// Samples the memory until the time is over; returns it with the time of warming up, s.
fn watch(live: &mut Live, pages: &[PageClient], run_for: Duration, out: &mut impl Write) -> Result<(Memory, f64)> {
    let (start, mut memory) = (Instant::now(), Memory::default());
    let mut shown = Duration::ZERO;
    while start.elapsed() < run_for {
        thread::sleep(SAMPLE.min(run_for.saturating_sub(start.elapsed())));
        live.check_runs()?;
        let time = start.elapsed();
        memory.add(time.as_secs_f64(), memory::resident_bytes(live.process())?);
        if time >= shown + PROGRESS {
            shown = time;
            let seen = pages.iter().map(PageClient::seen).collect::<Result<Vec<_>>>()?;
            writeln!(out, "{}", progress(time, &memory, seen.first()))?;
        }
    }
    Ok((memory, WARM_UP_S.min(run_for.as_secs_f64() / 3.0)))
}

/// A line; the latencies and counts are those of one page, if there is one.
fn progress(time: Duration, memory: &Memory, seen: Option<&Seen>) -> String {
    let minutes = (time.as_secs_f64() / 60.0).round();
    let memory = memory.last_bytes().map_or(f64::NAN, |bytes| bytes as f64 / 1e6);
    let Some(seen) = seen else { return format!("{minutes:.0} min: {memory:.1} MB") };
    let [p50, p99] = [0.5, 0.99].map(|part| quantile(seen.latencies_ms.iter().copied(), part));
    let counts: Vec<String> = seen.counts.iter().map(ToString::to_string).collect();
    format!("{minutes:.0} min: {memory:.1} MB, to the page p50 {p50:.1}, p99 {p99:.1} ms; {}", counts.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn minutes_and_rates_are_positive_numbers() {
        assert_eq!(positive("0.5"), Ok(0.5));
        for text in ["0", "-1", "nan", "inf", "ten"] {
            assert_eq!(positive(text), Err(format!("{text} is not a positive number")));
        }
    }

    #[test]
    fn a_recording_larger_than_the_disk_is_refused() {
        let folder = std::env::temp_dir();
        check_space(&folder, 0.0).unwrap();
        let error = check_space(&folder, 1e18).unwrap_err().to_string();
        assert!(error.starts_with("the recording takes about 1000000000.0 GB, but "), "{error}");
    }
}

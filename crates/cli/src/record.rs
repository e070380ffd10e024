//! `fingervision record`: writes frames, bit for bit, and readings of sensors to one file.

use std::io::Write;
use std::path::PathBuf;

use fingervision_pipeline::{Interest, Pace, Pipeline, Sensor};
use fingervision_recording::{Clock, RecorderOptions, RecorderProgress, RecorderThread};
use serde::Serialize;

use crate::disk;
use crate::failure::Failure;
use crate::live::sensors::{SensorArgs, SensorOptions};
use crate::live::status::{self, Beside, SensorSummary};
use crate::output::OutputArgs;
use crate::recording_file::{progress_text, refuse_other_names, summary_text};
use crate::threads;

/// Messages that may wait for the terminal.
const SHOWN_MESSAGES: usize = 256;

/// Record cameras, videos, folders or simulated presses to a file (MCAP): all frames unchanged, readings, events and
/// the profile
///
/// `fingervision track FILE.mcap` gives the same values as tracking the source; Foxglove and Rerun show the file. Ctrl-C
/// ends the recording. If the program is killed, less than the last second is missing.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// What to record: a camera, a video, a folder of images, a recording or a simulated scene; give several for
    /// several sensors
    ///
    /// As in `fingervision live`. Cameras are recorded in real time. For files and scenes every frame is tracked and
    /// recorded, however long this takes.
    #[arg(value_name = "SOURCE", required = true)]
    sources: Vec<PathBuf>,
    /// The file to write, as in press.mcap
    #[arg(value_name = "FILE.mcap", required = true)]
    file: PathBuf,
    #[command(flatten)]
    sensors: SensorOptions,
    /// End after this time, s, measured by the times of the frames
    #[arg(long, value_name = "N", value_parser = seconds)]
    seconds: Option<f64>,
    /// Record frames, events and the profile, but no readings: nothing is tracked, which takes less processor time
    #[arg(long)]
    frames_only: bool,
    /// Replace the file if it exists
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    output: OutputArgs,
}

#[derive(Debug, Serialize)]
struct RecordSummary {
    file: PathBuf,
    bytes: u64,
    seconds: f64,
    frames: u64,
    readings: u64,
    lost_messages: u64,
    sensors: Vec<SensorSummary>,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    refuse_other_names(&args.file, args.overwrite)?;
    let named = SensorArgs { sources: args.sources.clone(), options: args.sensors.clone() };
    let has_camera = named.has_camera()?;
    let (pace, clock) = if has_camera { (Pace::Recorded, Clock::Host) } else { (Pace::Lossless, Clock::Source) };
    let mut sensors = named.open(pace, args.output)?;
    if args.frames_only {
        sensors = sensors.into_iter().map(Sensor::without_tracking).collect();
    }
    let pipeline = Pipeline::prepare(sensors).with_workers(threads::count());
    let interest = RecorderThread::interest();
    let subscription = if has_camera { pipeline.subscribe(interest) } else { pipeline.subscribe_lossless(interest) };
    let shown = Interest { capacity: SHOWN_MESSAGES, ..Interest::readings() };
    let messages = pipeline.subscribe(shown);
    let options = RecorderOptions { clock, has_readings: !args.frames_only, most_seconds: args.seconds };
    let recorder = RecorderThread::start(&args.file, &pipeline.handles(), subscription, options)?;
    let running = pipeline.start()?;
    let sensors = status::show(running.handles(), &messages, &recorder, args.output);
    running.stop();
    let progress = recorder.finish();
    if progress.lost > 0 {
        let lost = progress.lost;
        args.output
            .note(&format!("{lost} frames or readings are not in the file: this computer or its disk is too slow"));
    }
    // After an error nobody knows how many of the frames are in the file.
    let text = if progress.error.is_some() {
        format!("{}: {} were written", args.file.display(), disk::size(progress.bytes))
    } else {
        format!("recorded {}", summary_text(&args.file, &progress))
    };
    let RecorderProgress { bytes, seconds, frames, readings, lost: lost_messages, error, .. } = progress;
    let summary = RecordSummary { file: args.file.clone(), bytes, seconds, frames, readings, lost_messages, sensors };
    args.output.result(out, &summary, &text)?;
    error.map_or(Ok(()), |[message, hint]| Err(Failure::new(message, hint)))
}

impl Beside for RecorderThread {
    fn text(&self) -> Option<String> {
        Some(progress_text(self.path(), &self.progress()))
    }

    fn is_over(&self) -> bool {
        let progress = self.progress();
        progress.is_complete || progress.is_ended
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds.is_finite() && seconds > 0.0 => Ok(seconds),
        _ => Err("a time is a number of seconds above 0".into()),
    }
}

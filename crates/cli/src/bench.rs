//! `fingervision bench`: how fast this machine tracks.

use std::fmt;
use std::io::Write;
use std::time::Instant;

use fearless_simd::Level;
use fingervision_touch::{Fields, Profile, Tracker};
use serde::Serialize;

use crate::doctor::instruction_set;
use crate::failure::Failure;
use crate::output::OutputArgs;
use crate::profile_args::ProfileArgs;
use crate::simulated_press::SimulatedPress;

/// Columns and rows of the gel in the camera image of a fingertip sensor, px.
const SIZE: (usize, usize) = (610, 450);
const RADIUS_PX: f64 = 80.0;
const AMPLITUDE_PX: f64 = 15.0;
/// Frames of a press; the bench repeats it.
const PRESS_FRAMES: u64 = 30;

/// Measure the speed of tracking on this machine, one thread
///
/// A press at 610x450 px is rendered first, outside the measurement. Then every frame is timed from its arrival to its
/// reading: flow, density and, with a calibrated profile, depth. Nothing is read or written meanwhile.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// How many frames to time
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = clap::value_parser!(u64).range(1..))]
    frames: u64,
    #[command(flatten)]
    profile: ProfileArgs,
    #[command(flatten)]
    output: OutputArgs,
}

/// Times of the frames, ms.
#[derive(Debug, Serialize)]
struct Speed {
    width: usize,
    height: usize,
    instruction_set: String,
    frames: usize,
    /// The first frame, which also prepares the reference; not among the others.
    first_ms: f64,
    p50_ms: f64,
    p90_ms: f64,
    p99_ms: f64,
    max_ms: f64,
    mean_ms: f64,
    frames_per_second: f64,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let profile = args.profile.load()?;
    let times = times(&profile, args)?;
    let speed = Speed::new(times[0], &times[1..]);
    args.output.result(out, &speed, &speed.to_string())
}

/// The time of the first frame and of all others, ms.
fn times(profile: &Profile, args: &Args) -> Result<Vec<f64>, Failure> {
    let press = SimulatedPress::new(SIZE, RADIUS_PX, AMPLITUDE_PX, PRESS_FRAMES)?;
    let mut frames = Vec::new();
    let rendered = PRESS_FRAMES.min(args.frames + 1);
    let progress = args.output.progress(Some(rendered + args.frames + 1));
    for sequence in 0..rendered {
        frames.push(press.frame(sequence)?);
        progress.inc(1);
    }
    let mut tracker = Tracker::new(profile, SIZE, true, Fields::default())?;
    let mut times = Vec::new();
    for sequence in 0..=args.frames {
        let frame = &mut frames[(sequence % PRESS_FRAMES) as usize];
        (frame.sequence, frame.capture_time_s) = (sequence, sequence as f64);
        let arrival = Instant::now();
        tracker.track(frame)?;
        times.push(1e3 * arrival.elapsed().as_secs_f64());
        progress.inc(1);
    }
    Ok(times)
}

impl Speed {
    fn new(first_ms: f64, times: &[f64]) -> Self {
        let mut sorted = times.to_vec();
        sorted.sort_by(f64::total_cmp);
        let mean_ms = sorted.iter().sum::<f64>() / sorted.len() as f64;
        Self {
            width: SIZE.0,
            height: SIZE.1,
            instruction_set: instruction_set(Level::new()),
            frames: sorted.len(),
            first_ms,
            p50_ms: percentile(&sorted, 50),
            p90_ms: percentile(&sorted, 90),
            p99_ms: percentile(&sorted, 99),
            max_ms: percentile(&sorted, 100),
            mean_ms,
            frames_per_second: 1e3 / mean_ms,
        }
    }
}

/// The smallest time that at least `percent` per cent of the times do not exceed. `sorted` holds at least one.
fn percentile(sorted: &[f64], percent: usize) -> f64 {
    sorted[(percent * sorted.len()).div_ceil(100).max(1) - 1]
}

impl fmt::Display for Speed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { width, height, instruction_set, frames, first_ms, frames_per_second, .. } = self;
        writeln!(f, "{frames} frames of {width}x{height} px in colour, one thread, {instruction_set}")?;
        writeln!(f, "{frames_per_second:.1} frames a second")?;
        writeln!(
            f,
            "ms a frame    p50 {:.1}  p90 {:.1}  p99 {:.1}  max {:.1}",
            self.p50_ms, self.p90_ms, self.p99_ms, self.max_ms
        )?;
        writeln!(f, "first frame   {first_ms:.1} ms: it also prepares the reference")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_percentile_is_a_time_that_was_measured() {
        let times: Vec<f64> = (1..=200).map(f64::from).collect();
        for (percent, expected) in [(50, 100.0), (90, 180.0), (99, 198.0), (100, 200.0)] {
            let time = percentile(&times, percent);
            assert!((time - expected).abs() < 1e-12, "p{percent} is {time}, expected {expected}");
        }
        assert!((percentile(&[7.0], 99) - 7.0).abs() < 1e-12);
    }
}

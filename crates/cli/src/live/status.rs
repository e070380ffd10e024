//! The output in the terminal while sensors run: a line that is updated, and events as notes.

use std::fmt::{self, Write};
use std::time::Duration;

use fingervision_pipeline::{Message, SensorHandle, Subscription};
use fingervision_touch::{HealthCounts, ReadingNumbers};
use indicatif::ProgressBar;
use serde::Serialize;

use crate::interrupt::Interrupt;
use crate::output::OutputArgs;

/// Interval at which the line is updated and the signal is tested.
const REFRESH: Duration = Duration::from_millis(200);

/// The state of a sensor, as the terminal shows it.
#[derive(Debug, Default)]
struct Shown {
    last: Option<ReadingNumbers>,
    health: HealthCounts,
    /// Capture times of the first and the last reading, s.
    times_s: Option<[f64; 2]>,
    /// Time from capture to reading of every reading since the last refresh, ms.
    latencies_ms: Vec<f64>,
}

/// The counts of a sensor, for the result.
#[derive(Debug, Serialize)]
pub(crate) struct SensorSummary {
    pub(crate) sensor: String,
    source: String,
    /// Frames that arrived.
    frames: u64,
    readings: u64,
    /// Rate of the readings; absent with fewer than two.
    frames_per_second: Option<f64>,
    dropped_by_camera: u64,
    dropped_before_tracking: u64,
    damaged: u64,
    /// Number of readings with each flag that was ever set.
    flagged: HealthCounts,
}

/// A recording beside the sensors.
pub(crate) trait Beside {
    /// The text that is shown behind the sensors.
    fn text(&self) -> Option<String>;

    /// Whether it is time to stop.
    fn is_over(&self) -> bool;
}

/// Shows messages until all sensors have ended, the user stops the command, or its time has passed.
pub(crate) fn show(
    handles: &[SensorHandle],
    messages: &Subscription,
    beside: &impl Beside,
    output: OutputArgs,
) -> Vec<SensorSummary> {
    let interrupt = Interrupt::listen();
    let line = output.line();
    let mut shown: Vec<Shown> = handles.iter().map(|_| Shown::default()).collect();
    let mut refreshed_s = fingervision_pipeline::host_time_s();
    while !interrupt.is_asked() && !messages.is_done() && !beside.is_over() {
        if let Some(message) = messages.next(REFRESH) {
            take(message, &mut shown, handles, &line, output);
        }
        let now_s = fingervision_pipeline::host_time_s();
        if now_s - refreshed_s >= REFRESH.as_secs_f64() {
            refreshed_s = now_s;
            line.set_message(text(&mut shown, handles, beside.text()));
        }
    }
    line.finish_and_clear();
    handles.iter().zip(&shown).map(|(handle, shown)| shown.summary(handle)).collect()
}

fn take(message: Message, shown: &mut [Shown], handles: &[SensorHandle], line: &ProgressBar, output: OutputArgs) {
    match message {
        Message::Reading { sensor, numbers, captured_s, ready_s, .. } => {
            let shown = &mut shown[sensor];
            let [first_s, _] = shown.times_s.unwrap_or([captured_s; 2]);
            shown.times_s = Some([first_s, captured_s]);
            shown.latencies_ms.push(1e3 * (ready_s - captured_s));
            shown.last = Some(numbers);
            shown.health.count(&numbers);
        }
        Message::Event { sensor, text, .. } => {
            line.suspend(|| output.note(&format!("{}: {text}", handles[sensor].name())));
        }
        _ => {}
    }
}

/// One line on all sensors.
fn text(shown: &mut [Shown], handles: &[SensorHandle], beside: Option<String>) -> String {
    let parts =
        shown.iter_mut().zip(handles).map(|(shown, handle)| format!("{}: {}", handle.name(), shown.text(handle)));
    parts.chain(beside).collect::<Vec<_>>().join(" | ")
}

impl Shown {
    fn text(&mut self, handle: &SensorHandle) -> String {
        if !handle.is_tracked() {
            return format!("{} frames", handle.counts().captured);
        }
        let Some(last) = self.last else { return "waiting".into() };
        let latency_ms = self.latencies_ms.iter().copied().fold(0.0, f64::max);
        self.latencies_ms.clear();
        // Writing to a String cannot fail.
        let rate = self.frames_per_second().unwrap_or_default();
        let mut text = format!("{rate:.0} frames/s, {latency_ms:.0} ms");
        if let Some(depth) = last.max_depth_mm {
            let _ = write!(text, ", {depth:.2} mm");
        }
        if let Some([_, _, force]) = last.force_n {
            let _ = write!(text, ", {force:.2} N");
        }
        for flag in last.flags.iter() {
            let _ = write!(text, ", {}", flag.name());
        }
        text
    }

    fn frames_per_second(&self) -> Option<f64> {
        let [first_s, last_s] = self.times_s.filter(|[first_s, last_s]| last_s > first_s)?;
        Some((self.health.readings().saturating_sub(1)) as f64 / (last_s - first_s))
    }

    fn summary(&self, handle: &SensorHandle) -> SensorSummary {
        let counts = handle.counts();
        SensorSummary {
            sensor: handle.name().into(),
            source: handle.description().into(),
            frames: counts.captured,
            readings: self.health.readings(),
            frames_per_second: self.frames_per_second(),
            dropped_by_camera: counts.camera.dropped,
            dropped_before_tracking: counts.dropped,
            damaged: counts.damaged + counts.camera.damaged,
            flagged: self.health.clone(),
        }
    }
}

impl fmt::Display for SensorSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { sensor, readings, .. } = self;
        write!(f, "{sensor}: {readings} readings")?;
        if let Some(rate) = self.frames_per_second {
            write!(f, ", {rate:.1} a second")?;
        }
        let (camera, tracking) = (self.dropped_by_camera, self.dropped_before_tracking);
        if camera + tracking > 0 {
            write!(f, "; dropped {camera} by the camera, {tracking} because tracking was busy")?;
        }
        if self.damaged > 0 {
            write!(f, "; {} damaged", self.damaged)?;
        }
        for (flag, count) in self.flagged.flagged() {
            write!(f, "\nflagged  {} in {count} of {readings} readings: {}", flag.name(), flag.sentence())?;
        }
        Ok(())
    }
}

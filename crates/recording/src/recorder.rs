//! A thread that records sensors while they run.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use fingervision_pipeline::{Interest, Message, SensorHandle, Subscription, host_time_s};
use fingervision_source::EncodedFrame;

use crate::{Clock, RecordedSensor, RecordingError, RecordingWriter};

/// How long the thread waits for a message before it checks whether a chunk must be written.
const WAIT: Duration = Duration::from_millis(100);
/// Longest time until the first frame of a sensor is tracked.
const LONGEST_START: Duration = Duration::from_secs(2);
/// Time between two surfaces of a sensor.
const SURFACE_PERIOD: Duration = Duration::from_millis(100);
/// Messages that may wait for the disk. Half of them are frames; a sensor provides at most about 190 at a time.
const WAITING_MESSAGES: usize = 256;

/// The progress of a recording.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct RecorderProgress {
    /// Bytes in the file.
    pub bytes: u64,
    /// Frames of all sensors, with the references that were captured before the recording began.
    pub frames: u64,
    /// Readings of all sensors.
    pub readings: u64,
    /// Time from the first frame to the last, s.
    pub seconds: f64,
    /// Messages that were lost because the disk or the computer was too slow; an event in the file marks the first
    /// loss.
    pub lost: u64,
    /// Why it ended early, and what to do about it.
    pub error: Option<[String; 2]>,
    /// All frames up to the requested time are written; their readings may follow.
    pub is_complete: bool,
    /// Nothing more is written.
    pub is_ended: bool,
}

/// Options of a recorder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecorderOptions {
    /// The clock of the messages' times.
    pub clock: Clock,
    /// Whether readings and surfaces are written beside the frames.
    pub has_readings: bool,
    /// Frames that are captured this long after a sensor's first one, or later, are not written, s.
    pub most_seconds: Option<f64>,
}

impl Default for RecorderOptions {
    /// Everything, without a time limit.
    fn default() -> Self {
        Self { clock: Clock::Host, has_readings: true, most_seconds: None }
    }
}

/// Records the messages of a subscription until it is stopped or dropped, the sensors end, or the disk is full.
#[derive(Debug)]
pub struct RecorderThread {
    path: PathBuf,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug)]
struct Shared {
    progress: Mutex<RecorderProgress>,
    is_stopped: AtomicBool,
    options: RecorderOptions,
}

/// The times of a sensor's frames, on the clock of the recording.
#[derive(Debug, Clone, Copy, Default)]
struct Times {
    first_s: Option<f64>,
    last_s: f64,
    /// A frame arrived after the time limit.
    is_complete: bool,
}

impl RecorderThread {
    /// The subscription of a recorder: every frame, the numbers of every reading, and ten whole readings a second for
    /// the surface.
    #[must_use]
    pub fn interest() -> Interest {
        Interest { frames: true, fields_every: Some(SURFACE_PERIOD), capacity: WAITING_MESSAGES }
    }

    /// Creates a file, or empties it, and starts to record.
    ///
    /// # Errors
    ///
    /// [`RecordingError::Write`] if the file cannot be written, [`RecordingError::Thread`] if a thread cannot be
    /// started.
    pub fn start(
        path: &Path,
        handles: &[SensorHandle],
        subscription: Subscription,
        options: RecorderOptions,
    ) -> Result<Self, RecordingError> {
        let of_handle = |handle: &SensorHandle| RecordedSensor::of(handle, options.clock);
        let sensors: Vec<RecordedSensor> = handles.iter().map(of_handle).collect();
        let mut writer = RecordingWriter::create(path, &sensors)?;
        for (index, scene) in
            handles.iter().enumerate().filter_map(|(index, handle)| Some((index, handle.scene_toml()?)))
        {
            writer.write_scene(index, scene)?;
        }
        let shared = Arc::new(Shared { progress: Mutex::default(), is_stopped: AtomicBool::new(false), options });
        let times = vec![Times::default(); sensors.len()];
        let handles = handles.to_vec();
        let recorder =
            Recorder { path: path.to_owned(), writer, subscription, handles, times, shared: Arc::clone(&shared) };
        let thread = thread::Builder::new().name("recorder".into()).spawn(move || recorder.run());
        let thread = thread.map_err(|error| RecordingError::Thread { path: path.to_owned(), error })?;
        Ok(Self { path: path.to_owned(), shared, thread: Some(thread) })
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its progress.
    #[must_use]
    pub fn progress(&self) -> RecorderProgress {
        self.shared.lock().clone()
    }

    /// Writes the messages that have arrived, closes the file, and returns its contents as progress.
    #[must_use]
    pub fn stop(mut self) -> RecorderProgress {
        self.end();
        self.progress()
    }

    /// Waits until the sensors have ended and everything is written, then as [`stop`](Self::stop).
    #[must_use]
    pub fn finish(mut self) -> RecorderProgress {
        self.join();
        self.progress()
    }

    fn end(&mut self) {
        self.shared.is_stopped.store(true, Ordering::Release);
        self.join();
    }

    fn join(&mut self) {
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has ended.
            let _ = thread.join();
        }
    }
}

impl Drop for RecorderThread {
    fn drop(&mut self) {
        self.end();
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, RecorderProgress> {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The state of the thread.
struct Recorder {
    path: PathBuf,
    writer: RecordingWriter,
    subscription: Subscription,
    handles: Vec<SensorHandle>,
    times: Vec<Times>,
    shared: Arc<Shared>,
}

impl Recorder {
    fn run(mut self) {
        let done = self.record();
        let Self { writer, subscription, shared, path, .. } = self;
        // Lossless sensors must not wait until the file is closed.
        drop(subscription);
        let done = done.and_then(|()| writer.finish());
        let mut progress = shared.lock();
        progress.is_ended = true;
        match done {
            Ok(bytes) => progress.bytes = bytes,
            Err(error) => {
                progress.error = Some([error.to_string(), error.hint()]);
                // What was written of the last chunk counts, too.
                progress.bytes = fs::metadata(&path).map_or(progress.bytes, |metadata| metadata.len());
            }
        }
    }

    fn record(&mut self) -> Result<(), RecordingError> {
        // Messages that are still written after a stop.
        let mut left = WAITING_MESSAGES;
        while !self.subscription.is_done() && left > 0 {
            let is_stopped = self.shared.is_stopped.load(Ordering::Acquire);
            left -= usize::from(is_stopped);
            match self.subscription.next(if is_stopped { Duration::ZERO } else { WAIT }) {
                Some(message) => self.write(&message)?,
                None if is_stopped => break,
                None => {}
            }
            self.writer.flush_due()?;
            self.note_progress()?;
        }
        Ok(())
    }

    fn write(&mut self, message: &Message) -> Result<(), RecordingError> {
        let (shared, writer) = (&self.shared, &mut self.writer);
        let RecorderOptions { clock, has_readings, most_seconds } = shared.options;
        match message {
            Message::Frame { sensor, frame, captured_s } => {
                let times = &mut self.times[*sensor];
                let time_s = time_s(clock, *captured_s, frame.capture_time_s);
                if times.is_late(time_s, most_seconds) {
                    times.is_complete = true;
                    return Ok(());
                }
                if times.first_s.is_none() {
                    times.first_s = Some(time_s);
                    await_reference(&self.handles[*sensor]);
                    let is_written = write_reference(writer, *sensor, &self.handles[*sensor], frame, *captured_s)?;
                    shared.lock().frames += u64::from(is_written);
                }
                times.last_s = time_s;
                writer.write_frame(*sensor, frame, *captured_s)?;
                shared.lock().frames += 1;
            }
            Message::Truth { sensor, sequence, capture_time_s, captured_s, truth } => {
                let time_s = time_s(clock, *captured_s, *capture_time_s);
                if !self.times[*sensor].is_late(time_s, most_seconds) {
                    writer.write_truth(*sensor, (*sequence, *capture_time_s), truth, *captured_s)?;
                }
            }
            Message::Reading { sensor, numbers, captured_s, .. } if has_readings => {
                let time_s = time_s(clock, *captured_s, numbers.capture_time_s);
                if !self.times[*sensor].is_late(time_s, most_seconds) {
                    writer.write_reading(*sensor, numbers, *captured_s)?;
                    shared.lock().readings += 1;
                }
            }
            Message::Fields { sensor, snapshot } if has_readings => {
                let time_s = time_s(clock, snapshot.captured_s, snapshot.reading.capture_time_s);
                if !self.times[*sensor].is_late(time_s, most_seconds) {
                    writer.write_surface(*sensor, &snapshot.reading, snapshot.captured_s)?;
                }
            }
            Message::Event { sensor, host_time_s, text } => writer.write_event(*sensor, text, *host_time_s)?,
            _ => {}
        }
        Ok(())
    }

    /// Stores the progress; writes an event into the file when messages are lost for the first time.
    fn note_progress(&mut self) -> Result<(), RecordingError> {
        let lost = self.subscription.lost();
        let mut progress = self.shared.lock();
        progress.bytes = self.writer.bytes_written();
        progress.seconds = self.times.iter().map(Times::duration_s).fold(0.0, f64::max);
        progress.is_complete = self.times.iter().all(|times| times.is_complete);
        let before = std::mem::replace(&mut progress.lost, lost);
        drop(progress);
        if before == 0 && lost > 0 {
            let text = "recording is too slow: frames or readings are missing from here on";
            self.writer.write_event(0, text, host_time_s())?;
        }
        Ok(())
    }
}

impl Times {
    fn is_late(&self, time_s: f64, most_seconds: Option<f64>) -> bool {
        most_seconds.zip(self.first_s).is_some_and(|(most_s, first_s)| time_s - first_s >= most_s)
    }

    fn duration_s(&self) -> f64 {
        self.first_s.map_or(0.0, |first_s| self.last_s - first_s)
    }
}

/// Waits for the reference of a sensor that has just been opened: its first frame may have been captured before this recording
/// began, and not yet been tracked. Messages wait in the subscription meanwhile.
fn await_reference(handle: &SensorHandle) {
    let begin = Instant::now();
    let is_coming = || handle.is_tracked() && !handle.is_ended() && handle.reference().is_none();
    while is_coming() && begin.elapsed() < LONGEST_START {
        thread::sleep(Duration::from_millis(1));
    }
}

/// Writes the reference, if it is older than the first frame of the recording: readings are relative to it, and tracking the
/// recording begins with its first frame. Its message has the time of the first frame, because displays show the time
/// from the first message on; it contains its own number and time. Returns whether it was written.
fn write_reference(
    writer: &mut RecordingWriter,
    sensor: usize,
    handle: &SensorHandle,
    first: &EncodedFrame,
    first_captured_s: f64,
) -> Result<bool, RecordingError> {
    let Some((reference, captured_s)) = handle.reference().filter(|(frame, _)| frame.sequence < first.sequence) else {
        return Ok(false);
    };
    writer.write_reference(sensor, &reference, captured_s, (first.capture_time_s, first_captured_s))?;
    let (sequence, age_s) = (reference.sequence, first_captured_s - captured_s);
    let text =
        format!("the first frame is the reference, frame {sequence}, captured {age_s:.1} s before the recording");
    writer.write_event(sensor, &text, first_captured_s)?;
    Ok(true)
}

fn time_s(clock: Clock, captured_s: f64, capture_time_s: f64) -> f64 {
    match clock {
        Clock::Host => captured_s,
        Clock::Source => capture_time_s,
    }
}

//! The actions that the page requests: the record button.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use fingervision_page::Actions;
use fingervision_pipeline::{SensorHandle, Subscriptions};
use fingervision_recording::{RecorderOptions, RecorderProgress, RecorderThread, RecordingError};

use crate::live::status::Beside;
use crate::recording_file::{progress_text, summary_text};

/// Records all sensors of a live command, on request of the page or from the start.
#[derive(Debug)]
pub(crate) struct LiveActions {
    handles: Vec<SensorHandle>,
    subscriptions: Subscriptions,
    recorder: Mutex<Option<RecorderThread>>,
}

impl LiveActions {
    pub(crate) fn new(handles: &[SensorHandle], subscriptions: Subscriptions) -> Self {
        Self { handles: handles.to_vec(), subscriptions, recorder: Mutex::default() }
    }

    /// Begins a recording.
    pub(super) fn record(&self, path: &Path) -> Result<(), RecordingError> {
        let subscription = self.subscriptions.subscribe(RecorderThread::interest());
        let recorder = RecorderThread::start(path, &self.handles, subscription, RecorderOptions::default())?;
        *self.lock() = Some(recorder);
        Ok(())
    }

    /// Closes the recording, if there is one; returns its result.
    pub(super) fn close(&self) -> Option<String> {
        let recorder = self.lock().take()?;
        let path = recorder.path().to_owned();
        Some(ended_text(&path, &recorder.stop()))
    }

    /// Closes the recording, and sends its file, length and any error as an event.
    fn close_aloud(&self) {
        if let Some(text) = self.close() {
            self.subscriptions.announce(0, text);
        }
    }

    /// Closes a recording that has ended by itself while sensors run, for example because the disk is full.
    fn close_ended(&self) {
        let is_ended = self.lock().as_ref().is_some_and(|recorder| recorder.progress().is_ended);
        if is_ended && !self.handles.iter().all(SensorHandle::is_ended) {
            self.close_aloud();
        }
    }

    fn lock(&self) -> MutexGuard<'_, Option<RecorderThread>> {
        self.recorder.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// One sentence on a recording that has ended.
pub(super) fn ended_text(path: &Path, progress: &RecorderProgress) -> String {
    match &progress.error {
        Some([error, hint]) => format!("recording has ended: {error}; {hint}"),
        None => format!("recorded {}", summary_text(path, progress)),
    }
}

impl Actions for LiveActions {
    fn set_recording(&self, on: bool) -> Result<Option<PathBuf>, String> {
        if !on {
            self.close_aloud();
            return Ok(None);
        }
        if let Some(recorder) = self.lock().as_ref() {
            return Ok(Some(recorder.path().to_owned()));
        }
        let name = chrono::Local::now().format("recording-%Y%m%d-%H%M%S.mcap").to_string();
        let path = PathBuf::from(name);
        if path.exists() {
            return Err(format!("{} exists already: try again in a second", path.display()));
        }
        self.record(&path).map_err(|error| format!("{error}; {}", error.hint()))?;
        Ok(Some(path))
    }

    fn recording(&self) -> Option<(PathBuf, u64, f64)> {
        self.close_ended();
        self.lock().as_ref().map(|recorder| {
            let progress = recorder.progress();
            (recorder.path().to_owned(), progress.bytes, progress.seconds)
        })
    }
}

impl Beside for LiveActions {
    fn text(&self) -> Option<String> {
        self.close_ended();
        self.lock().as_ref().map(|recorder| progress_text(recorder.path(), &recorder.progress()))
    }

    fn is_over(&self) -> bool {
        false
    }
}

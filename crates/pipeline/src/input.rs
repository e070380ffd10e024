//! The origin of a sensor's frames: a camera or a source.

use std::time::{Duration, Instant};

use fingervision_camera::{Arrived, Camera, CameraError};
use fingervision_image::Frame;
use fingervision_source::{EncodedFrame, FrameTruth, Source};

use crate::clock::captured_s;
use crate::host_time_s;
use crate::next::Next;
use crate::replay::Replay;

/// A camera is started again if it sends nothing for this number of frame periods, within these limits: an exposure may
/// take longer than a period.
const PERIODS: f64 = 20.0;
const LEAST_PATIENCE: Duration = Duration::from_secs(1);
const MOST_PATIENCE: Duration = Duration::from_secs(10);

/// A longer gap between frames is not waited for, s.
const LONGEST_GAP_S: f64 = 2.0;

/// How fast the frames of a file or a simulation are delivered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pace {
    /// At their recorded times. If tracking is too slow, frames are dropped, as with a camera.
    Recorded,
    /// As fast as they are tracked; no frame is dropped.
    Lossless,
}

/// A camera, or a source of recorded or simulated frames.
pub struct Input {
    kind: Kind,
    pace: Pace,
}

enum Kind {
    Camera(Box<Camera>),
    Source(Box<Player>),
    Replay(Replay),
}

impl Input {
    /// A camera.
    #[must_use]
    pub fn camera(camera: Camera) -> Self {
        Self { kind: Kind::Camera(Box::new(camera)), pace: Pace::Recorded }
    }

    /// A file, a folder or a simulation.
    #[must_use]
    pub fn source(source: Box<dyn Source>, pace: Pace) -> Self {
        Self { kind: Kind::Source(Box::new(Player { source, start: None, last_s: None, waiting: None })), pace }
    }

    /// Encoded frames in memory. Those that arrive while tracking is busy are dropped.
    #[must_use]
    pub fn replay(replay: Replay) -> Self {
        Self { kind: Kind::Replay(replay), pace: Pace::Recorded }
    }

    /// Time to wait for the next frame; a camera that sends nothing for this time is started again. Stopping takes up
    /// to this time.
    pub(crate) fn patience(&self) -> Duration {
        let period_s = match &self.kind {
            Kind::Camera(camera) => 1.0 / camera.mode().frames_per_second,
            Kind::Source(_) | Kind::Replay(_) => 0.0,
        };
        Duration::try_from_secs_f64(PERIODS * period_s).unwrap_or(MOST_PATIENCE).clamp(LEAST_PATIENCE, MOST_PATIENCE)
    }

    pub(crate) fn pace(&self) -> Pace {
        self.pace
    }

    /// One line on where the frames come from.
    #[must_use]
    pub fn description(&self) -> String {
        match &self.kind {
            Kind::Camera(camera) => format!("{}: {}", camera.id(), camera.mode()),
            Kind::Source(player) => player.source.description(),
            Kind::Replay(replay) => replay.description(),
        }
    }

    /// Remarks that do not prevent reading, one sentence each.
    #[must_use]
    pub fn remarks(&self) -> Vec<String> {
        match &self.kind {
            Kind::Camera(camera) => camera.remarks().to_vec(),
            Kind::Source(player) => player.source.remarks(),
            Kind::Replay(_) => Vec::new(),
        }
    }

    /// Whether the colour of the frames has their full resolution; see [`Source::has_full_colour`]. Cameras deliver what the
    /// flow is computed from.
    pub(crate) fn has_full_colour(&self) -> bool {
        match &self.kind {
            Kind::Source(player) => player.source.has_full_colour(),
            Kind::Camera(_) | Kind::Replay(_) => true,
        }
    }

    /// The truth of the frame that came last, if it is simulated.
    pub(crate) fn truth(&self) -> Option<FrameTruth> {
        match &self.kind {
            Kind::Camera(_) | Kind::Replay(_) => None,
            Kind::Source(player) => player.source.truth(),
        }
    }

    /// The scene, as TOML, if it is simulated.
    pub(crate) fn scene_toml(&self) -> Option<String> {
        match &self.kind {
            Kind::Camera(_) | Kind::Replay(_) => None,
            Kind::Source(player) => player.source.scene_toml(),
        }
    }

    /// The camera's counts.
    pub(crate) fn camera_counts(&self) -> Option<fingervision_camera::Counts> {
        match &self.kind {
            Kind::Camera(camera) => Some(camera.counts()),
            Kind::Source(_) | Kind::Replay(_) => None,
        }
    }

    /// Waits for the next frame and writes it to `frame`.
    pub(crate) fn next(&mut self, wait: Duration, frame: &mut EncodedFrame) -> Next {
        match &mut self.kind {
            Kind::Camera(camera) => next_of_camera(camera, wait, frame),
            Kind::Source(player) => player.next(self.pace, wait, frame),
            Kind::Replay(replay) => replay.next(wait, frame),
        }
    }
}

fn next_of_camera(camera: &mut Camera, wait: Duration, frame: &mut EncodedFrame) -> Next {
    match camera.next_encoded(wait, frame) {
        Ok(Some(Arrived::Frame)) => Next::Frame { captured_s: captured_s(frame.capture_time_s) },
        Ok(Some(Arrived::Event(event))) => Next::Event(event.to_string()),
        Ok(None) => Next::Nothing,
        // The next call starts the camera again.
        Err(error @ CameraError::TimedOut { .. }) => Next::Event(error.to_string()),
        Err(error) => Next::End(Some(error.into())),
    }
}

/// Delivers the frames of a source at their times.
struct Player {
    source: Box<dyn Source>,
    /// When the first frame was delivered, and its recorded time.
    start: Option<(Instant, f64)>,
    /// The recorded time of the last frame.
    last_s: Option<f64>,
    /// A frame that is not due yet, and the recorded time since the one before, s.
    waiting: Option<(Frame, f64)>,
}

impl Player {
    /// Time since the last frame, as recorded, s. What follows a long gap is due as if there were none: after the reference
    /// of a recording that began later, or a camera that was unplugged.
    fn skip_gap(&mut self, time_s: f64) -> f64 {
        let gap_s = time_s - self.last_s.replace(time_s).unwrap_or(time_s);
        if gap_s <= LONGEST_GAP_S {
            return gap_s;
        }
        if let Some((_, first_s)) = &mut self.start {
            *first_s += gap_s;
        }
        0.0
    }

    fn next(&mut self, pace: Pace, wait: Duration, into: &mut EncodedFrame) -> Next {
        let (frame, gap_s) = match self.waiting.take() {
            Some(waiting) => waiting,
            None => match self.source.next_frame() {
                Ok(Some(frame)) => {
                    let gap_s = self.skip_gap(frame.capture_time_s);
                    (frame, gap_s)
                }
                Ok(None) => return Next::End(None),
                Err(error) if self.source.resume() => return Next::Damaged(error.to_string()),
                Err(error) => return Next::End(Some(error.into())),
            },
        };
        let (start, first_s) = *self.start.get_or_insert((Instant::now(), frame.capture_time_s));
        if pace == Pace::Recorded {
            let due = Duration::try_from_secs_f64(frame.capture_time_s - first_s).unwrap_or_default();
            let elapsed = start.elapsed();
            let (left, late) = (due.saturating_sub(elapsed), elapsed.saturating_sub(due));
            std::thread::sleep(left.min(wait));
            if left > wait {
                self.waiting = Some((frame, gap_s));
                return Next::Nothing;
            }
            // A source can be late because it renders its images. It then continues at its rate: if it caught up at once,
            // the tracker would drop frames.
            if late.as_secs_f64() > gap_s {
                self.start = Some((start + late, first_s));
            }
        }
        into.load(&frame);
        Next::Frame { captured_s: host_time_s() }
    }
}

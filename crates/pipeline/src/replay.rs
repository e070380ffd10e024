//! Encoded frames that are played at a steady rate, as cameras deliver them.

use std::sync::{Arc, OnceLock};
use std::time::Duration;

use fingervision_source::{CameraLayout, EncodedFrame};

use crate::host_time_s;
use crate::next::Next;

/// Time before the second frame, s: each tracker first prepares its reference.
const LEAD_S: f64 = 1.0;

/// Frames in memory, played forwards and backwards in turn. Clones are further sensors: their frames are due at the same times.
///
/// The first frame comes at once. A frame is captured when it is due, however late it is returned, so that latencies
/// count from there.
#[derive(Debug, Clone)]
pub struct Replay {
    frames: Arc<[Vec<u8>]>,
    layout: CameraLayout,
    period_s: f64,
    /// Frames to play.
    count: u64,
    next: u64,
    /// When the second frame is due.
    start_s: Arc<OnceLock<f64>>,
}

impl Replay {
    /// Plays `count` frames, `frames_per_second` of them a second, which is positive. The first of `frames` shows the
    /// gel at rest.
    #[must_use]
    pub fn new(frames: Vec<Vec<u8>>, layout: CameraLayout, frames_per_second: f64, count: u64) -> Self {
        let (frames, start_s) = (frames.into(), Arc::default());
        Self { frames, layout, period_s: 1.0 / frames_per_second, count, next: 0, start_s }
    }

    /// One line on where the frames come from.
    pub(crate) fn description(&self) -> String {
        format!("{} frames in memory, {:.1} frames/s", self.frames.len(), 1.0 / self.period_s)
    }

    pub(crate) fn next(&mut self, wait: Duration, frame: &mut EncodedFrame) -> Next {
        if self.next >= self.count || self.frames.is_empty() {
            return Next::End(None);
        }
        let due_s = self.due_s();
        if let Ok(left) = Duration::try_from_secs_f64(due_s - host_time_s()) {
            std::thread::sleep(left.min(wait));
            if left > wait {
                return Next::Nothing;
            }
        }
        frame.sequence = self.next;
        frame.capture_time_s = self.next as f64 * self.period_s;
        frame.layout = self.layout;
        frame.bytes.clone_from(&self.frames[place_of(self.next, self.frames.len())]);
        self.next += 1;
        Next::Frame { captured_s: due_s }
    }

    fn due_s(&self) -> f64 {
        match self.next.checked_sub(1) {
            Some(periods) => self.start_s.get_or_init(|| host_time_s() + LEAD_S) + periods as f64 * self.period_s,
            None => host_time_s(),
        }
    }
}

/// The index of a frame of a film that runs forwards, backwards, forwards, ….
fn place_of(number: u64, frames: usize) -> usize {
    let last = frames.saturating_sub(1) as u64;
    let at = number % (2 * last).max(1);
    at.min(2 * last - at.min(2 * last)) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_film_runs_forwards_and_backwards() {
        let order: Vec<usize> = (0..8).map(|number| place_of(number, 4)).collect();
        assert_eq!(order, [0, 1, 2, 3, 2, 1, 0, 1]);
        assert_eq!([0, 1, 2].map(|number| place_of(number, 1)), [0; 3]);
        assert_eq!([0, 1, 2, 3].map(|number| place_of(number, 2)), [0, 1, 0, 1]);
    }
}

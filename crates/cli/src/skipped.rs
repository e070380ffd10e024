//! Frames of a run that cannot be read and are skipped.

use fingervision_image::Frame;
use fingervision_source::{Source, SourceError};
use serde::Serialize;

use crate::failure::Failure;
use crate::output::OutputArgs;

/// Number of frames that are named on standard error; all are counted.
const MOST_NAMED: usize = 10;

/// The skipped frames.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Skipped {
    /// Frames missing among those read: the bad ones, and in a video those that depend on them.
    #[serde(rename = "skipped_frames")]
    pub(crate) count: u64,
    /// The reason for each that could not be read.
    #[serde(rename = "bad_frames")]
    reasons: Vec<String>,
    #[serde(skip)]
    previous: Option<u64>,
}

impl Skipped {
    /// The next frame that can be read.
    ///
    /// # Errors
    ///
    /// The error of a frame that cannot be read, if `skips` is false or reading cannot continue.
    pub(crate) fn next_frame(
        &mut self,
        source: &mut dyn Source,
        skips: bool,
        output: OutputArgs,
    ) -> Result<Option<Frame>, Failure> {
        let known = self.reasons.len();
        loop {
            match source.next_frame() {
                Ok(frame) => {
                    let bad = (self.reasons.len() - known) as u64;
                    if bad > 0 {
                        self.count_to(frame.as_ref().map(|frame| frame.sequence).or(source.frame_count()), bad);
                    }
                    self.previous = frame.as_ref().map(|frame| frame.sequence).or(self.previous);
                    return Ok(frame);
                }
                Err(error) if skips && source.resume() => self.note(error.to_string(), output),
                Err(error @ SourceError::Frame { sequence: 1.., .. }) if !skips => {
                    return Err(Failure::new(
                        error.to_string(),
                        "the frames before it are complete: skip it with --skip-bad-frames, or record again",
                    ));
                }
                Err(error) => return Err(error.into()),
            }
        }
    }

    /// The number of the last frame that was read.
    pub(crate) fn last_read(&self) -> Option<u64> {
        self.previous
    }

    /// Counts the frames missing before a frame, at least the bad ones.
    fn count_to(&mut self, next: Option<u64>, bad: u64) {
        let expected = self.previous.map_or(0, |previous| previous + 1);
        self.count += next.unwrap_or(expected).saturating_sub(expected).max(bad);
    }

    fn note(&mut self, reason: String, output: OutputArgs) {
        if self.reasons.len() < MOST_NAMED {
            output.note(&format!("skipped: {reason}"));
        } else if self.reasons.len() == MOST_NAMED {
            output.note("more frames are skipped; --json lists all of them");
        }
        self.reasons.push(reason);
    }
}

//! Reads and decodes the frames of a run on a thread of its own, ahead of tracking.

use std::sync::mpsc::sync_channel;
use std::thread;

use fingervision_image::Frame;
use fingervision_source::Source;

use crate::failure::Failure;
use crate::output::OutputArgs;
use crate::part::Part;
use crate::skipped::Skipped;

/// Frames that are read ahead.
const AHEAD: usize = 2;

/// The next frame, `None` after the last.
pub(crate) type Next<'n> = dyn FnMut() -> Result<Option<Frame>, Failure> + 'n;

/// Which frames of a source are read.
pub(crate) struct Reader<'r> {
    pub(crate) source: &'r mut dyn Source,
    pub(crate) skipped: &'r mut Skipped,
    /// Whether a frame that cannot be read is skipped.
    pub(crate) skips: bool,
    pub(crate) part: Part,
    pub(crate) output: OutputArgs,
}

impl Reader<'_> {
    /// Calls `work` with the frames. With more than one thread they are read while it works.
    pub(crate) fn read<R>(mut self, work: impl FnOnce(&mut Next<'_>) -> R) -> R {
        if rayon::current_num_threads() == 1 {
            return work(&mut || self.next());
        }
        let (send, receive) = sync_channel(AHEAD);
        thread::scope(|scope| {
            scope.spawn(move || {
                loop {
                    let next = self.next();
                    // What comes after the part is not read: it may be damaged.
                    let is_last = next.as_ref().map_or(true, |frame| {
                        frame.as_ref().is_none_or(|frame| self.part.is_behind(frame.sequence + 1))
                    });
                    if send.send(next).is_err() || is_last {
                        return;
                    }
                }
            });
            // The receiver is dropped with the closure, which ends the thread.
            work(&mut move || receive.recv().unwrap_or(Ok(None)))
        })
    }

    fn next(&mut self) -> Result<Option<Frame>, Failure> {
        self.skipped.next_frame(self.source, self.skips, self.output)
    }
}

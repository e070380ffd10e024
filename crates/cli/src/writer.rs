//! Writes the readings of a run on a thread of its own, behind tracking.

use std::sync::mpsc::{channel, sync_channel};
use std::thread;

use fingervision_image::Frame;
use fingervision_sink::{Overlay, Preview, RunFolder, Sink, SinkError};
use fingervision_touch::{Reading, Tracker};

use crate::failure::Failure;
use crate::summary::Tally;

/// Readings that may wait to be written.
const BEHIND: usize = 4;

/// Writes the tracker's last reading, which is that of this frame. Until the next frame the tracker has none.
pub(crate) type Put<'p> = dyn FnMut(&mut Tracker, Frame) -> Result<(), Failure> + 'p;

/// A run that has begun: everything that takes its readings.
pub(crate) struct Sinks {
    pub(crate) folder: RunFolder,
    pub(crate) preview: Preview,
    pub(crate) overlay: Option<Overlay>,
    pub(crate) tally: Tally,
}

impl Sinks {
    /// Calls `work` with what writes readings. With more than one thread they are completed and written while it works, and
    /// all have been written when this returns.
    ///
    /// # Errors
    ///
    /// The error of `work`, or why a reading could not be written; none is written after that.
    pub(crate) fn take(
        &mut self,
        tracker: &mut Tracker,
        work: impl FnOnce(&mut Tracker, &mut Put<'_>) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        if rayon::current_num_threads() == 1 {
            return work(tracker, &mut |tracker, frame| Ok(self.write(tracker.reading(), &frame)?));
        }
        let mut density = tracker.defer_density();
        let (send, receive) = sync_channel::<(Reading, Frame)>(BEHIND);
        // Readings that were written: their memory is used again.
        let (give_back, spares) = channel();
        thread::scope(|scope| {
            let writer = scope.spawn(move || {
                for (mut reading, frame) in receive {
                    if let Some(density) = &mut density {
                        density.complete(&mut reading);
                    }
                    self.write(&reading, &frame)?;
                    // Nobody needs them after the last frame.
                    let _ = give_back.send(reading);
                }
                Ok::<(), SinkError>(())
            });
            // The sender is dropped with the closure, which ends the thread.
            let worked = work(tracker, &mut move |tracker, frame| {
                let reading = tracker.take_reading(spares.try_recv().ok());
                send.send((reading, frame)).map_err(|_| Failure::new("nothing more can be written", ""))
            });
            match writer.join() {
                Ok(written) => written.map_err(Failure::from).and(worked),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        })
    }

    fn write(&mut self, reading: &Reading, frame: &Frame) -> Result<(), SinkError> {
        self.folder.write(reading, frame)?;
        self.tally.count(reading);
        self.preview.write(reading, frame)?;
        if let Some(overlay) = &mut self.overlay {
            overlay.write(reading, frame)?;
        }
        Ok(())
    }
}

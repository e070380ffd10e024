//! The tracking thread of a sensor.

use std::sync::Arc;
use std::time::Duration;

use fingervision_source::{CameraFrameDecoder, CameraLayout, EncodedFrame};
use fingervision_touch::{Flag, ReadingNumbers, Tracker};

use crate::captured::Captured;
use crate::hub::Hub;
use crate::pool::Pool;
use crate::queue::Queue;
use crate::sensor::{SensorHandle, frame_of};
use crate::{Message, Snapshot, host_time_s};

/// How often the thread checks whether its queue was closed.
const WAIT: Duration = Duration::from_secs(1);
/// Snapshots that may be in use at the same time.
const MOST_SNAPSHOTS: usize = 4;

/// Tracks until the queue is closed and empty.
pub(crate) struct Track {
    pub(crate) index: usize,
    pub(crate) tracker: Tracker,
    pub(crate) decoder: CameraFrameDecoder,
    pub(crate) layout: CameraLayout,
    pub(crate) handle: SensorHandle,
    /// The first frame, which is the reference: it must not be dropped.
    pub(crate) first: Captured,
    pub(crate) hub: Arc<Hub>,
    pub(crate) queue: Arc<Queue<Captured>>,
    /// A new reference was requested, and no frame has been tracked since.
    pub(crate) is_rezeroing: bool,
}

impl Track {
    pub(crate) fn run(mut self) {
        let (handle, hub, queue) = (self.handle.clone(), Arc::clone(&self.hub), Arc::clone(&self.queue));
        let _end = End { index: self.index, handle, hub, queue };
        let mut snapshots = Pool::new(MOST_SNAPSHOTS);
        let mut first = Some(self.first.clone());
        while first.is_some() || !self.queue.is_done() {
            let Some(captured) = first.take().or_else(|| self.queue.pop(WAIT)) else { continue };
            match self.track(&captured.frame) {
                Ok(numbers) => {
                    self.note_reference(&numbers);
                    self.publish(numbers, &captured, &mut snapshots);
                }
                Err(reason) => {
                    self.handle.shared.count(|counts| counts.damaged += 1);
                    self.event(format!("frame {} is left out: {reason}", captured.frame.sequence));
                }
            }
        }
    }

    fn track(&mut self, frame: &EncodedFrame) -> Result<ReadingNumbers, String> {
        if frame.layout != self.layout {
            // The camera was opened again and may have another mode; the tracker refuses frames of another size.
            (self.layout, self.decoder) = (frame.layout, CameraFrameDecoder::new(frame.layout));
        }
        let pixels = self.decoder.decode(&frame.bytes)?;
        if self.handle.shared.take_rezero() {
            self.tracker.rezero();
            self.is_rezeroing = true;
        }
        let reading = self.tracker.track(&frame_of(frame, pixels)).map_err(|error| error.to_string())?;
        Ok(reading.numbers)
    }

    /// Logs a new reference, before the first reading that is relative to it.
    fn note_reference(&mut self, numbers: &ReadingNumbers) {
        let (is_asked, sequence) = (std::mem::take(&mut self.is_rezeroing), numbers.sequence);
        if is_asked {
            self.event(format!("re-zeroed at frame {sequence}"));
        } else if numbers.flags.has(Flag::NewReference) {
            self.event(format!("frame {sequence} is relative to a new reference, which the tracker took by its rules"));
        }
    }

    fn publish(&self, numbers: ReadingNumbers, captured: &Captured, snapshots: &mut Pool<Snapshot>) {
        let (sensor, captured_s, ready_s) = (self.index, captured.captured_s, host_time_s());
        self.handle.shared.count(|counts| counts.tracked += 1);
        self.hub.publish(&Message::Reading { sensor, numbers, captured_s, ready_s });
        self.hub.publish_fields(sensor, ready_s, || {
            let reading = self.tracker.reading();
            let frame = &captured.frame;
            let make = || Snapshot { reading: reading.clone(), frame: Arc::clone(frame), captured_s, ready_s };
            let slot = snapshots.free(make)?;
            let snapshot = Arc::get_mut(slot)?;
            snapshot.reading.copy_from(reading);
            snapshot.frame = Arc::clone(frame);
            (snapshot.captured_s, snapshot.ready_s) = (captured_s, ready_s);
            Some(Message::Fields { sensor, snapshot: Arc::clone(slot) })
        });
    }

    fn event(&self, text: String) {
        self.hub.publish(&Message::Event { sensor: self.index, host_time_s: host_time_s(), text });
    }
}

/// Tells all subscribers that the sensor has ended, also after a panic.
struct End {
    index: usize,
    handle: SensorHandle,
    hub: Arc<Hub>,
    queue: Arc<Queue<Captured>>,
}

impl Drop for End {
    fn drop(&mut self) {
        // Capture must not wait for a tracker that has ended.
        self.queue.close();
        self.handle.shared.end();
        self.hub.publish(&Message::End { sensor: self.index });
    }
}

//! Tracks the frames of a sensor, one after the other, on whatever thread has time.

use std::sync::Arc;
use std::time::{Duration, Instant};

use fingervision_image::Frame;
use fingervision_source::{CameraFrameDecoder, CameraLayout, EncodedFrame};
use fingervision_touch::{Flag, ReadingNumbers, Tracker};

use crate::captured::Captured;
use crate::hub::Hub;
use crate::message::FrameTimes;
use crate::pool::Pool;
use crate::queue::Queue;
use crate::ready::Left;
use crate::sensor::SensorHandle;
use crate::{Message, Snapshot, host_time_s};

/// Snapshots that may be in use at the same time.
const MOST_SNAPSHOTS: usize = 4;

/// Tracks the frames of one sensor. When it is dropped, all subscribers get [`Message::End`].
pub(crate) struct Track {
    index: usize,
    /// Absent if frames are not tracked; then none comes.
    tracker: Option<Tracker>,
    decoder: CameraFrameDecoder,
    layout: CameraLayout,
    handle: SensorHandle,
    /// The first frame, which is the reference: it must not be dropped.
    first: Option<Captured>,
    /// The pixels of the frame that is tracked.
    frame: Frame,
    hub: Arc<Hub>,
    queue: Arc<Queue<Captured>>,
    snapshots: Pool<Snapshot>,
    /// A new reference was requested, and no frame has been tracked since.
    is_rezeroing: bool,
}

impl Track {
    /// For a sensor whose first frame was decoded to `frame` and, if there is a tracker, is still to be tracked.
    pub(crate) fn new(
        index: usize,
        (tracker, decoder): (Option<Tracker>, CameraFrameDecoder),
        (first, frame): (Captured, Frame),
        handle: SensorHandle,
        (hub, queue): (Arc<Hub>, Arc<Queue<Captured>>),
    ) -> Self {
        let (layout, snapshots) = (first.frame.layout, Pool::new(MOST_SNAPSHOTS));
        let first = tracker.is_some().then_some(first);
        Self { index, tracker, decoder, layout, handle, first, frame, hub, queue, snapshots, is_rezeroing: false }
    }

    /// Tracks the oldest frame, if there is one.
    pub(crate) fn step(&mut self) -> Left {
        let Some(captured) = self.first.take().or_else(|| self.queue.pop(Duration::ZERO)) else {
            return if self.queue.is_done() { Left::End } else { Left::Nothing };
        };
        let waiting_ms = 1e3 * (host_time_s() - captured.captured_s);
        match self.track(&captured.frame, waiting_ms) {
            Ok((numbers, times)) => {
                self.keep_reference(&captured);
                self.note_reference(&numbers);
                self.publish(numbers, &captured, times);
            }
            Err(reason) => {
                self.handle.shared.count(|counts| counts.damaged += 1);
                self.event(format!("frame {} is left out: {reason}", captured.frame.sequence));
            }
        }
        Left::More
    }

    /// The numbers of a frame's reading, and the times that it took.
    fn track(&mut self, frame: &EncodedFrame, waiting_ms: f64) -> Result<(ReadingNumbers, FrameTimes), String> {
        let begin = Instant::now();
        if frame.layout != self.layout {
            // The camera was opened again and may have another mode; the tracker refuses frames of another size.
            (self.layout, self.decoder) = (frame.layout, CameraFrameDecoder::for_tracking(frame.layout));
        }
        let tracker = self.tracker.as_mut().ok_or("it is not tracked")?;
        self.decoder.decode_into(&frame.bytes, &mut self.frame.pixels)?;
        (self.frame.sequence, self.frame.capture_time_s) = (frame.sequence, frame.capture_time_s);
        let decode_ms = 1e3 * begin.elapsed().as_secs_f64();
        if self.handle.shared.take_rezero() {
            tracker.rezero();
            self.is_rezeroing = true;
        }
        let numbers = tracker.track(&self.frame).map_err(|error| error.to_string())?.numbers;
        Ok((numbers, FrameTimes { waiting_ms, decode_ms, stages: tracker.stage_times() }))
    }

    /// Keeps the frame that was tracked last for recordings that begin later, if it is the reference now.
    fn keep_reference(&self, captured: &Captured) {
        let reference = self.tracker.as_ref().and_then(Tracker::reference_sequence);
        if reference == Some(captured.frame.sequence) {
            self.handle.shared.set_reference(captured);
        }
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

    fn publish(&mut self, numbers: ReadingNumbers, captured: &Captured, times: FrameTimes) {
        let (sensor, captured_s, ready_s) = (self.index, captured.captured_s, host_time_s());
        self.handle.shared.count(|counts| counts.tracked += 1);
        self.hub.publish(&Message::Reading { sensor, numbers, captured_s, ready_s, times });
        let snapshots = &mut self.snapshots;
        self.hub.publish_fields(sensor, ready_s, || {
            let reading = self.tracker.as_ref()?.reading();
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

impl Drop for Track {
    fn drop(&mut self) {
        // Capture must not wait for a tracker that has ended.
        self.queue.close();
        self.handle.shared.end();
        self.hub.publish(&Message::End { sensor: self.index });
    }
}

//! Captures frames from one camera.
//!
//! Every frame of the driver is returned once, decoded, with its number and its time. A camera that is unplugged, or
//! whose driver reports an error, is closed, and opened again by its stable id as soon as it is present. Until then no
//! frame is returned; an old frame is never returned again.

mod event;
mod open;
#[cfg(test)]
mod tests;

use std::io;
use std::mem;
use std::time::{Duration, Instant};

use fingervision_image::Frame;
use fingervision_source::{CameraFrameDecoder, CameraLayout, EncodedFrame};
use fingervision_touch::CaptureSection;

use crate::error::is_gone;
use crate::numbering::{Arrival, Numbering};
use crate::{Bus, CameraError, Device, Layout, Mode, Node, select};

pub use event::{Arrived, Captured, Counts, Event};

/// Time between two attempts to find a camera that is missing.
const LOOK_AGAIN: Duration = Duration::from_millis(100);
/// Number of failed starts, of a camera that is present, before an error is returned. Just after it was plugged in, the
/// permission may not have been granted yet.
const MOST_FAILURES: u32 = 30;

/// A camera that captures.
pub struct Camera {
    bus: Box<dyn Bus>,
    /// The node in use; its number may change when the camera is plugged in again, its id does not.
    node: Node,
    capture: CaptureSection,
    layout: Layout,
    /// Absent while the camera is missing.
    device: Option<Box<dyn Device>>,
    frame_layout: CameraLayout,
    decoder: CameraFrameDecoder,
    /// The frame that [`Camera::next`] decodes.
    encoded: EncodedFrame,
    numbering: Numbering,
    counts: Counts,
    remarks: Vec<String>,
    /// Attempts to start since the last frame.
    failures: u32,
}

impl Camera {
    /// Opens the camera that `capture` names, sets its mode, locks its controls and starts it.
    ///
    /// # Errors
    ///
    /// [`CameraError`] if no camera matches, if it cannot be opened, or if it does not offer the mode.
    pub fn open(bus: Box<dyn Bus>, capture: CaptureSection) -> Result<Self, CameraError> {
        let node = select(bus.as_ref(), capture.camera.as_deref())?;
        let open::Started { device, layout, frame_layout, remarks } = open::start(bus.as_ref(), &node, &capture)?;
        let numbering = Numbering::new(layout.mode.frames_per_second);
        Ok(Self {
            bus,
            node,
            capture,
            layout,
            device: Some(device),
            frame_layout,
            decoder: CameraFrameDecoder::for_tracking(frame_layout),
            encoded: EncodedFrame::empty(),
            numbering,
            counts: Counts::default(),
            remarks,
            failures: 0,
        })
    }

    /// The next frame or event. `None` if the camera is missing and does not return within `wait`.
    ///
    /// # Errors
    ///
    /// [`CameraError::TimedOut`] if the camera is present but sends no new frame within `wait`; the next call starts it
    /// again. Any other error that remains after several attempts to open the camera.
    pub fn next(&mut self, wait: Duration) -> Result<Option<Captured>, CameraError> {
        let mut encoded = mem::replace(&mut self.encoded, EncodedFrame::empty());
        let arrived = self.next_encoded(wait, &mut encoded);
        self.encoded = encoded;
        Ok(match arrived? {
            None => None,
            Some(Arrived::Event(event)) => Some(Captured::Event(event)),
            Some(Arrived::Frame) => Some(self.decoded()),
        })
    }

    /// As [`next`](Self::next), but the frame is written to `frame` as the camera sent it. Allocates nothing if the
    /// bytes fit into those of `frame`.
    ///
    /// # Errors
    ///
    /// As [`next`](Self::next).
    pub fn next_encoded(&mut self, wait: Duration, frame: &mut EncodedFrame) -> Result<Option<Arrived>, CameraError> {
        let start = Instant::now();
        loop {
            let Some(device) = self.device.as_mut() else { return self.reopen(start, wait) };
            let buffer = match device.next(wait) {
                Ok(buffer) => buffer,
                Err(error) => return self.lose(&error, wait).map(|event| Some(Arrived::Event(event))),
            };
            let Arrival::New { sequence, time_s, missed, is_clock_step } =
                self.numbering.arrive(buffer.sequence, buffer.stamp_s)
            else {
                self.counts.duplicates += 1;
                if start.elapsed() < wait {
                    continue;
                }
                self.device = None;
                return Err(self.timed_out(wait));
            };
            self.failures = 0;
            self.counts.dropped += missed;
            self.counts.clock_steps += u64::from(is_clock_step);
            if buffer.is_damaged {
                self.counts.damaged += 1;
                let reason = "the driver reports it as damaged".to_owned();
                return Ok(Some(Arrived::Event(Event::Damaged { sequence, reason })));
            }
            self.counts.frames += 1;
            (frame.sequence, frame.capture_time_s, frame.layout) = (sequence, time_s, self.frame_layout);
            frame.bytes.clear();
            frame.bytes.extend_from_slice(buffer.bytes);
            return Ok(Some(Arrived::Frame));
        }
    }

    /// The pixels of the frame that arrived.
    fn decoded(&mut self) -> Captured {
        let EncodedFrame { sequence, capture_time_s, ref bytes, .. } = self.encoded;
        match self.decoder.decode(bytes) {
            Ok(pixels) => Captured::Frame(Frame { sequence, capture_time_s, pixels }),
            Err(reason) => {
                self.counts.frames -= 1;
                self.counts.damaged += 1;
                Captured::Event(Event::Damaged { sequence, reason })
            }
        }
    }

    /// The id of the camera.
    #[must_use]
    pub fn id(&self) -> &str {
        &self.node.id
    }

    /// The node in use.
    #[must_use]
    pub fn node(&self) -> &Node {
        &self.node
    }

    /// How the bytes of its frames lie in memory.
    #[must_use]
    pub fn frame_layout(&self) -> CameraLayout {
        self.frame_layout
    }

    /// The current mode.
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.layout.mode
    }

    /// Counts of the frames so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Settings that differ from those of the profile, a sentence each.
    #[must_use]
    pub fn remarks(&self) -> &[String] {
        &self.remarks
    }

    /// The error of a camera that is missing for too long.
    pub(crate) fn unplugged(&self) -> CameraError {
        CameraError::Unplugged { camera: self.node.id.clone() }
    }

    /// Closes the camera after an error.
    fn lose(&mut self, error: &io::Error, wait: Duration) -> Result<Event, CameraError> {
        self.device = None;
        if error.kind() == io::ErrorKind::TimedOut {
            return Err(self.timed_out(wait));
        }
        let is_gone = is_gone(error);
        self.failures += u32::from(!is_gone);
        if self.failures > MOST_FAILURES {
            let error = io::Error::new(error.kind(), error.to_string());
            return Err(CameraError::io(&self.node.id, self.node.path.clone(), "capture", error));
        }
        Ok(if is_gone { Event::Unplugged } else { Event::Failed { reason: error.to_string() } })
    }

    fn timed_out(&self, wait: Duration) -> CameraError {
        CameraError::TimedOut { camera: self.node.id.clone(), waited_s: wait.as_secs_f64() }
    }

    /// Opens the camera again if it is present; tries at least once.
    fn reopen(&mut self, start: Instant, wait: Duration) -> Result<Option<Arrived>, CameraError> {
        loop {
            // Only the names are compared: opening other cameras would switch them on.
            if let Some(node) = self.bus.nodes().into_iter().find(|node| node.id == self.node.id) {
                match open::start(self.bus.as_ref(), &node, &self.capture) {
                    Ok(started) => return Ok(Some(Arrived::Event(self.go_on(node, started)))),
                    Err(error) => {
                        self.failures += u32::from(!is_away(&error));
                        if self.failures > MOST_FAILURES {
                            return Err(error);
                        }
                    }
                }
            }
            if start.elapsed() >= wait {
                return Ok(None);
            }
            self.bus.pause(LOOK_AGAIN.min(wait));
        }
    }

    fn go_on(&mut self, node: Node, started: open::Started) -> Event {
        let open::Started { device, layout, frame_layout, remarks } = started;
        self.numbering.restart(layout.mode.frames_per_second);
        self.counts.restarts += 1;
        (self.node, self.device, self.layout) = (node, Some(device), layout);
        (self.frame_layout, self.decoder) = (frame_layout, CameraFrameDecoder::for_tracking(frame_layout));
        self.remarks = remarks;
        Event::Restarted
    }
}

/// Whether a camera was unplugged while it was opened.
fn is_away(error: &CameraError) -> bool {
    matches!(error, CameraError::Io { error, .. } if is_gone(error))
}

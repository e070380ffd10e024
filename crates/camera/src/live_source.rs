//! A camera as a source of frames, for commands that read recordings.

use std::time::{Duration, Instant};

use fingervision_image::Frame;
use fingervision_source::{Source, SourceError};

use crate::{Camera, CameraError, Captured};

/// How long one call to the camera waits for a frame.
const WAIT: Duration = Duration::from_secs(2);
/// After this time without a frame the source ends with an error.
const LONGEST_ABSENCE: Duration = Duration::from_secs(10);

/// The frames of an open camera, without end. A gap in the sequence numbers shows missing frames.
pub struct CameraSource {
    camera: Camera,
    is_ended: bool,
}

impl CameraSource {
    /// Frames of an open camera.
    #[must_use]
    pub fn new(camera: Camera) -> Self {
        Self { camera, is_ended: false }
    }

    fn next(&mut self) -> Result<Frame, CameraError> {
        let start = Instant::now();
        loop {
            match self.camera.next(WAIT) {
                Ok(Some(Captured::Frame(frame))) => return Ok(frame),
                Err(error @ CameraError::TimedOut { .. }) if start.elapsed() >= LONGEST_ABSENCE => return Err(error),
                Ok(None) if start.elapsed() >= LONGEST_ABSENCE => return Err(self.camera.unplugged()),
                Ok(_) | Err(CameraError::TimedOut { .. }) => {}
                Err(error) => return Err(error),
            }
        }
    }
}

impl Source for CameraSource {
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        if self.is_ended {
            return Ok(None);
        }
        self.next().map(Some).map_err(|error| {
            self.is_ended = true;
            error.into()
        })
    }

    fn frame_count(&self) -> Option<u64> {
        None
    }

    fn size(&self) -> (usize, usize) {
        let layout = self.camera.frame_layout();
        (layout.width, layout.height)
    }

    fn description(&self) -> String {
        format!("camera {}: {}", self.camera.id(), self.camera.mode())
    }

    fn remarks(&self) -> Vec<String> {
        self.camera.remarks().to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fake::{Coming, FakeBus};
    use fingervision_touch::CaptureSection;

    const INPUT_OUTPUT: i32 = 5;

    #[test]
    fn frames_come_as_from_a_file_and_an_error_ends_them() {
        let bus = FakeBus::new(&["usb-left"]);
        bus.send(&[1, 2, 4]);
        let camera = Camera::open(Box::new(bus.clone()), CaptureSection::default()).unwrap();
        let mut source = CameraSource::new(camera);
        assert_eq!((source.size(), source.frame_count()), ((4, 2), None));
        let sequences: Vec<u64> = (0..3).map(|_| source.next_frame().unwrap().unwrap().sequence).collect();
        assert_eq!(sequences, [0, 1, 3]);
        bus.with(|world| world.coming.extend((0..40).map(|_| Coming::Error(INPUT_OUTPUT))));
        let error = source.next_frame().unwrap_err();
        assert!(error.to_string().starts_with("usb-left: capture: "), "{error}");
        assert!(source.next_frame().unwrap().is_none());
    }
}

//! The camera of a guided calibration: its newest image, and images that are taken on request.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use fingervision_image::Pixels;
use fingervision_page::Page;
use fingervision_pipeline::{Input, Interest, Message, Pace, Pipeline, Running, Sensor, Subscription, host_time_s};
use fingervision_source::{CameraFrameDecoder, EncodedFrame};
use fingervision_touch::{Fields, Profile};

use super::shoot::Pictures;
use crate::failure::Failure;
use crate::live::{LiveActions, PageArgs};
use crate::output::OutputArgs;
use crate::place::Place;
use crate::threads;

/// Frames that may wait while an image is written.
const FRAMES: usize = 64;
/// After this time without a frame the camera counts as missing.
const PATIENCE: Duration = Duration::from_secs(10);

/// A running camera, and the page that shows its image.
pub(super) struct LiveCamera {
    frames: Subscription,
    decoder: Option<CameraFrameDecoder>,
    output: OutputArgs,
    _page: Page,
    _running: Running,
}

impl LiveCamera {
    /// Starts the camera and the page.
    pub(super) fn open(camera: &Path, profile: Profile, page: PageArgs, output: OutputArgs) -> Result<Self, Failure> {
        let place = Place::of(camera)?;
        let input = if let Place::Camera(id) = &place {
            Input::camera(fingervision_camera::open(profile.capture_from(id.as_deref()))?)
        } else {
            Input::source(place.source(&profile, output)?, Pace::Recorded)
        };
        let sensor = Sensor::open("calibration", profile, input, Fields::NONE)?;
        for remark in sensor.remarks() {
            output.note(&remark);
        }
        let pipeline = Pipeline::prepare(vec![sensor]).with_workers(threads::count());
        let frames = pipeline.subscribe(Interest { frames: true, capacity: FRAMES, ..Interest::readings() });
        let messages = pipeline.subscribe(Interest::readings());
        let running = pipeline.start()?;
        let actions = Arc::new(LiveActions::new(running.handles(), running.subscriptions()));
        let page = page.start(&running, messages, actions)?;
        output.note(&format!("the camera's image: {}", page.url()));
        Ok(Self { frames, decoder: None, output, _page: page, _running: running })
    }

    /// The pixels of a frame; none if it is damaged.
    fn pixels(&mut self, frame: &EncodedFrame) -> Option<Pixels> {
        let decoder = self.decoder.get_or_insert_with(|| CameraFrameDecoder::for_tracking(frame.layout));
        match decoder.decode(&frame.bytes) {
            Ok(pixels) => Some(pixels),
            Err(reason) => {
                self.output.note(&format!("frame {} is left out: {reason}", frame.sequence));
                self.decoder = None;
                None
            }
        }
    }
}

impl Pictures for LiveCamera {
    fn newest(&mut self) -> Option<Pixels> {
        let mut newest = None;
        while let Some(message) = self.frames.next(Duration::ZERO) {
            match message {
                Message::Frame { frame, .. } => newest = Some(frame),
                Message::Event { text, .. } => self.output.note(&text),
                _ => {}
            }
        }
        let newest = newest?;
        self.pixels(&newest)
    }

    fn next_after_now(&mut self) -> Result<Pixels, Failure> {
        let (asked_s, start) = (host_time_s(), Instant::now());
        while start.elapsed() < PATIENCE && !self.frames.is_done() {
            match self.frames.next(Duration::from_millis(100)) {
                Some(Message::Frame { frame, captured_s, .. }) if captured_s > asked_s => {
                    if let Some(pixels) = self.pixels(&frame) {
                        return Ok(pixels);
                    }
                }
                Some(Message::Event { text, .. }) => self.output.note(&text),
                _ => {}
            }
        }
        let message = format!("the camera sent no image within {} s", PATIENCE.as_secs());
        Err(Failure::new(message, "look whether it is plugged in: fingervision doctor"))
    }
}

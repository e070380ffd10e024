//! Cameras of a real kernel: vivid, a camera that makes its own pictures, and v4l2loopback, which sends what a program
//! writes. `cargo xtask camera-test` boots a kernel that has them; elsewhere these tests are left out.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test may fail where it stands")]

mod command;
mod loopback;
mod producer;
mod vivid;

use fingervision_camera::{Bus, Camera, CameraError, Captured, Event, Video4Linux};
use fingervision_image::Frame;
use fingervision_touch::CaptureSection;
use std::path::PathBuf;
use std::time::Duration;

/// Longer than the emulator needs for a frame.
const WAIT: Duration = Duration::from_secs(5);

fn wanted(camera: &str, format: &str, size_px: [u32; 2]) -> CaptureSection {
    CaptureSection {
        camera: Some(camera.into()),
        format: Some(format.into()),
        size_px: Some(size_px),
        ..CaptureSection::default()
    }
}

/// The node of the camera with this name.
fn node(card: &str) -> PathBuf {
    Video4Linux::default().nodes().into_iter().find(|node| node.card == card).unwrap().path
}

fn open(capture: CaptureSection) -> Result<Camera, CameraError> {
    Camera::open(Box::new(Video4Linux::default()), capture)
}

fn next_frame(camera: &mut Camera) -> Frame {
    match camera.next(WAIT).unwrap() {
        Some(Captured::Frame(frame)) => frame,
        other => panic!("not a frame: {other:?}"),
    }
}

/// The first event, over any frames before it.
fn next_event(camera: &mut Camera) -> Event {
    for _ in 0..200 {
        match camera.next(WAIT).unwrap() {
            Some(Captured::Event(event)) => return event,
            Some(Captured::Frame(_)) | None => (),
        }
    }
    panic!("no event in 200 calls");
}

/// Numbers and times of frames must grow.
fn expect_growth(frames: &[Frame]) {
    for pair in frames.windows(2) {
        assert!(pair[1].sequence > pair[0].sequence, "{} after {}", pair[1].sequence, pair[0].sequence);
        assert!(pair[1].capture_time_s > pair[0].capture_time_s);
    }
}

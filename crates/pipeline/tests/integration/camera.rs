//! A camera that fails on demand.

use crate::until_the_end;
use fingervision_camera::Camera;
use fingervision_camera::fake::{Coming, FakeBus};
use fingervision_gel::{Light, Motion, Sheet, SheetRenderer};
use fingervision_pipeline::{Input, Interest, Message, Pipeline, PipelineError, Sensor, Subscription};
use fingervision_touch::{CaptureSection, Fields, Profile};
use std::time::Duration;

/// The number of the system's error for a device that is gone.
const NO_DEVICE: i32 = 19;
const SIZE: [u32; 2] = [96, 80];

/// The bytes of a pattern that is pushed further in every frame.
fn grey(sequence: u32) -> Vec<u8> {
    let sheet = Sheet { width: SIZE[0] as usize, height: SIZE[1] as usize, ..Sheet::default() };
    let motion = Motion::shift(0.3 * f64::from(sequence));
    let image = SheetRenderer::new(&sheet).unwrap().render(&motion, Light::EVEN, u64::from(sequence)).unwrap();
    image.values().iter().map(|pixel| pixel[1]).collect()
}

fn frame(sequence: u32) -> Coming {
    Coming::Frame { sequence, stamp_s: 10.0 + 0.01 * f64::from(sequence), bytes: grey(sequence), is_damaged: false }
}

fn bus(coming: Vec<Coming>) -> FakeBus {
    let bus = FakeBus::new(&["usb-left"]);
    bus.with(|world| {
        world.grey_size = SIZE;
        world.coming.extend(coming);
    });
    bus
}

fn sensor(bus: &FakeBus) -> Result<Sensor, PipelineError> {
    let camera = Camera::open(Box::new(bus.clone()), CaptureSection::default())?;
    Sensor::open("left", Profile::default(), Input::camera(camera), Fields::NONE)
}

/// Numbers of readings and sentences, until the reading with this number has come.
fn until(subscription: &Subscription, last: u64) -> (Vec<u64>, Vec<String>) {
    let (mut numbers, mut sentences) = (Vec::new(), Vec::new());
    while numbers.last() != Some(&last) {
        match subscription.next(Duration::from_mins(1)).unwrap() {
            Message::Reading { numbers: reading, .. } => numbers.push(reading.sequence),
            Message::Event { text, .. } => sentences.push(text),
            _ => {}
        }
    }
    (numbers, sentences)
}

#[test]
fn a_camera_that_was_unplugged_goes_on_with_new_frames() {
    let mut coming: Vec<Coming> = (0..3).map(frame).collect();
    coming.push(Coming::Error(NO_DEVICE));
    // After a restart the driver counts from 0; its clock goes on.
    coming.push(Coming::Frame { sequence: 0, stamp_s: 10.1, bytes: grey(10), is_damaged: false });
    let bus = bus(coming);
    let pipeline = Pipeline::prepare(vec![sensor(&bus).unwrap()]);
    let subscription = pipeline.subscribe(Interest::readings());
    let running = pipeline.start().unwrap();
    let (numbers, sentences) = until(&subscription, 10);
    running.stop();
    assert_eq!(numbers.last(), Some(&10));
    assert!(numbers.windows(2).all(|pair| pair[1] > pair[0]), "{numbers:?}");
    // On a busy machine a pause may follow.
    let expected = ["the camera is unplugged; capture goes on when it is back", "the camera captures again"];
    assert_eq!(sentences[..2], expected, "{sentences:?}");
}

#[test]
fn a_silent_camera_is_started_again_and_said_so() {
    let mut coming: Vec<Coming> = (0..2).map(frame).collect();
    coming.push(Coming::Silence);
    coming.push(frame(5));
    let bus = bus(coming);
    let pipeline = Pipeline::prepare(vec![sensor(&bus).unwrap()]);
    let subscription = pipeline.subscribe(Interest::readings());
    let running = pipeline.start().unwrap();
    let (numbers, sentences) = until(&subscription, 5);
    assert_eq!(numbers.last(), Some(&5));
    assert_eq!(sentences[0], "usb-left: no frame in 1.0 s");
    assert!(running.handles()[0].counts().camera.restarts >= 1);
    running.stop();
}

#[test]
fn a_frame_that_is_cut_off_is_left_out() {
    let mut coming: Vec<Coming> = (0..2).map(frame).collect();
    coming.push(Coming::Frame { sequence: 2, stamp_s: 10.02, bytes: vec![0; 100], is_damaged: false });
    coming.push(frame(3));
    let bus = bus(coming);
    let pipeline = Pipeline::prepare(vec![sensor(&bus).unwrap()]);
    let subscription = pipeline.subscribe(Interest::readings());
    let running = pipeline.start().unwrap();
    let (numbers, sentences) = until(&subscription, 3);
    running.stop();
    assert!(!numbers.contains(&2), "{numbers:?}");
    // The frame may have been dropped before it was decoded, because all came at once. On a busy machine the silence after the last
    // frame may be reported, too.
    let mut of_frames = sentences.iter().filter(|text| text.starts_with("frame "));
    assert!(of_frames.all(|text| text.starts_with("frame 2 is left out: cut off")), "{sentences:?}");
}

#[test]
fn a_camera_that_sends_nothing_is_refused() {
    let bus = bus(Vec::new());
    let error = sensor(&bus).err().unwrap();
    assert_eq!(error.to_string(), "left: no usable frame: usb-left: no frame in 5.0 s");
}

#[test]
fn first_frames_that_are_cut_off_are_passed_over() {
    let cut = |sequence| Coming::Frame { sequence, stamp_s: 10.0, bytes: vec![1; 7], is_damaged: false };
    let bus = bus(vec![cut(0), cut(1), frame(2)]);
    assert!(sensor(&bus).is_ok());
}

#[test]
fn a_camera_that_fails_for_good_ends_the_sensor_with_a_reason() {
    let bus = bus(vec![frame(0)]);
    let pipeline = Pipeline::prepare(vec![sensor(&bus).unwrap()]);
    let subscription = pipeline.subscribe(Interest::readings());
    // An input/output error, again and again.
    bus.with(|world| world.coming.extend((0..40).map(|_| Coming::Error(5))));
    let running = pipeline.start().unwrap();
    let sentences: Vec<String> = until_the_end(&subscription)
        .into_iter()
        .filter_map(|message| match message {
            Message::Event { text, .. } => Some(text),
            _ => None,
        })
        .collect();
    let last = sentences.last().unwrap();
    assert!(last.starts_with("capture has ended: usb-left: capture: "), "{last}");
    assert!(running.handles()[0].is_ended());
}

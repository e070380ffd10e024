//! A camera that is recorded, and unplugged meanwhile.

use fingervision_camera::Camera;
use fingervision_camera::fake::{Coming, FakeBus};
use fingervision_pipeline::{Input, Pipeline, Sensor};
use fingervision_recording::{RecorderOptions, RecorderThread, Recording, RecordingSource};
use fingervision_source::EncodedFrame;
use fingervision_touch::{CaptureSection, Fields, Profile};

/// The number of the system's error for a device that is gone.
const NO_DEVICE: i32 = 19;
const SIZE: [u32; 2] = [96, 80];

fn grey(number: u32) -> Vec<u8> {
    let value = |index: u32| ((index / 7 % 13 * (index / 672 % 11 + 1) + number % 5) % 256) as u8;
    (0..SIZE[0] * SIZE[1]).map(value).collect()
}

fn coming(sequence: u32, number: u32) -> Coming {
    let (stamp_s, bytes) = (10.0 + 0.01 * f64::from(number), grey(number));
    Coming::Frame { sequence, stamp_s, bytes, is_damaged: false }
}

#[test]
fn bytes_numbers_times_and_events_of_a_camera_are_in_the_file() {
    let bus = FakeBus::new(&["usb-left"]);
    bus.with(|world| {
        world.grey_size = SIZE;
        // Frame 3 is missing. After the restart the driver counts from 0.
        world.coming.extend([0, 1, 2, 4].map(|number| coming(number, number)));
        world.coming.extend([Coming::Error(NO_DEVICE), coming(0, 10), coming(1, 11)]);
    });
    let camera = Camera::open(Box::new(bus.clone()), CaptureSection::default()).unwrap();
    let sensor = Sensor::open("left", Profile::default(), Input::camera(camera), Fields::NONE).unwrap();
    let pipeline = Pipeline::prepare(vec![sensor]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mcap");
    let subscription = pipeline.subscribe(RecorderThread::interest());
    let options = RecorderOptions::default();
    let recorder = RecorderThread::start(&path, &pipeline.handles(), subscription, options).unwrap();
    let running = pipeline.start().unwrap();
    while recorder.progress().frames < 6 {
        std::thread::yield_now();
    }
    let progress = recorder.stop();
    running.stop();
    assert_eq!((progress.lost, progress.error), (0, None));

    let recording = Recording::open(&path).unwrap();
    let events = recording.events(0).unwrap();
    // On a busy machine events of a camera without frames may follow.
    assert_eq!(events[..2], ["the camera is unplugged; capture goes on when it is back", "the camera captures again"]);
    let mut source = RecordingSource::open(recording, 0).unwrap();
    let mut frame = EncodedFrame::empty();
    for (sequence, number) in [(0, 0), (1, 1), (2, 2), (4, 4), (10, 10), (11, 11)] {
        assert!(source.next_encoded(&mut frame).unwrap());
        assert_eq!(frame.sequence, sequence);
        assert!((frame.capture_time_s - (10.0 + 0.01 * f64::from(number))).abs() < 1e-12, "{}", frame.capture_time_s);
        assert!(frame.bytes == grey(number), "frame {number}");
    }
    assert!(!source.next_encoded(&mut frame).unwrap());
}

//! The recorder beside running sensors.

use std::path::Path;

use fingervision_image::{Frame, Image, Pixels};
use fingervision_pipeline::{Input, Pace, Pipeline, Sensor};
use fingervision_recording::{Clock, RecorderOptions, RecorderThread, Recording, RecordingError, RecordingSource};
use fingervision_source::{FrameTruth, Source, SourceError};
use fingervision_touch::{Fields, Profile};

const SIZE: usize = 96;

/// A pattern that moves by a pixel per frame. Every tenth frame is missing.
struct Film {
    next: u64,
    frames: u64,
}

fn frame(number: u64) -> Frame {
    let value = |x: usize, y: usize| {
        let (x, y) = (x as u64 + number, y as u64);
        ((x / 5 * 2_654_435_761) ^ (y / 5 * 40_503_000_003)).wrapping_mul(0x9e37_79b9_7f4a_7c15).to_be_bytes()[0]
    };
    let sequence = number + number / 9;
    Frame { sequence, capture_time_s: sequence as f64 / 90.0, pixels: Pixels::Grey8(Image::from_fn(SIZE, SIZE, value)) }
}

fn truth(number: u64) -> FrameTruth {
    FrameTruth { depth_mm: number as f64, force_n: [0.0, 0.0, 0.5 * number as f64], torque_nmm: 0.0 }
}

impl Source for Film {
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        self.next += 1;
        Ok((self.next <= self.frames).then(|| frame(self.next - 1)))
    }

    fn frame_count(&self) -> Option<u64> {
        Some(self.frames)
    }

    fn size(&self) -> (usize, usize) {
        (SIZE, SIZE)
    }

    fn truth(&self) -> Option<FrameTruth> {
        Some(truth(self.next - 1))
    }

    fn scene_toml(&self) -> Option<String> {
        Some("name = \"film\"".into())
    }

    fn description(&self) -> String {
        "a film".into()
    }
}

fn sensor(name: &str, frames: u64) -> Sensor {
    let film = Box::new(Film { next: 0, frames });
    Sensor::open(name, Profile::default(), Input::source(film, Pace::Lossless), Fields::default()).unwrap()
}

#[test]
fn every_frame_and_reading_of_a_lossless_pipeline_is_in_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mcap");
    let pipeline = Pipeline::prepare(vec![sensor("left", 300), sensor("right", 40)]);
    let subscription = pipeline.subscribe_lossless(RecorderThread::interest());
    let options = RecorderOptions { clock: Clock::Source, ..RecorderOptions::default() };
    let recorder = RecorderThread::start(&path, &pipeline.handles(), subscription, options).unwrap();
    let running = pipeline.start().unwrap();
    let progress = recorder.finish();
    running.stop();
    assert_eq!((progress.frames, progress.readings, progress.lost, progress.error), (340, 340, 0, None));
    assert_eq!(progress.bytes, std::fs::metadata(&path).unwrap().len());
    let recording = Recording::open(&path).unwrap();
    assert!(!recording.is_cut_off());
    for (sensor, frames) in [(0, 300), (1, 40)] {
        let mut source = RecordingSource::open(recording.clone(), sensor).unwrap();
        for number in 0..frames {
            assert_eq!(source.next_frame().unwrap(), Some(frame(number)));
        }
        assert!(source.next_frame().unwrap().is_none());
        assert_eq!(recording.readings(sensor).unwrap().len() as u64, frames);
        let truths: Vec<_> = recording.truths(sensor).unwrap().iter().map(|recorded| recorded.truth).collect();
        assert_eq!(truths, (0..frames).map(truth).collect::<Vec<_>>());
        assert_eq!(recording.scene_toml(sensor), Some("name = \"film\""));
    }
}

#[test]
fn a_recording_ends_at_its_time_with_the_readings_of_all_its_frames() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mcap");
    let pipeline = Pipeline::prepare(vec![sensor("left", 200)]);
    let subscription = pipeline.subscribe_lossless(RecorderThread::interest());
    let options = RecorderOptions { clock: Clock::Source, most_seconds: Some(1.0), ..RecorderOptions::default() };
    let recorder = RecorderThread::start(&path, &pipeline.handles(), subscription, options).unwrap();
    let running = pipeline.start().unwrap();
    let progress = recorder.finish();
    running.stop();
    let within = (0..200).filter(|number| frame(*number).capture_time_s < 1.0).count() as u64;
    assert_eq!((progress.frames, progress.readings, progress.is_complete), (within, within, true));
}

#[test]
fn a_recording_that_begins_later_starts_with_the_reference() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mcap");
    let running = Pipeline::prepare(vec![sensor("left", u64::MAX)]).start().unwrap();
    let handle = running.handles()[0].clone();
    let wait_until = |is_due: &dyn Fn() -> bool| {
        while !is_due() {
            std::thread::yield_now();
        }
    };
    wait_until(&|| handle.counts().tracked > 5);
    let record = || {
        let subscription = running.subscriptions().subscribe(RecorderThread::interest());
        let recorder =
            RecorderThread::start(&path, running.handles(), subscription, RecorderOptions::default()).unwrap();
        wait_until(&|| recorder.progress().frames >= 3);
        let progress = recorder.stop();
        assert_eq!(progress.error, None);
        let recording = Recording::open(&path).unwrap();
        assert_eq!(recording.sensors()[0].frames, progress.frames, "with the reference");
        let mut source = RecordingSource::open(recording.clone(), 0).unwrap();
        let [first, second] = [0, 1].map(|_| source.next_frame().unwrap().unwrap());
        let event = recording.events(0).unwrap().into_iter().next().unwrap();
        (first, second.sequence, event)
    };
    let (reference, second, event) = record();
    assert_eq!(reference, frame(0), "bit by bit, with its own number and time");
    assert!(second > 5, "{second}");
    assert!(event.contains("the first frame is the reference, frame 0, captured "), "{event}");
    handle.rezero();
    wait_until(&|| handle.reference().unwrap().0.sequence > 0);
    let reference = record().0.sequence;
    assert_eq!(reference, handle.reference().unwrap().0.sequence);
    running.stop();
}

#[test]
fn a_recording_that_begins_before_the_first_frame_is_tracked_starts_with_it() {
    let folder = tempfile::tempdir().unwrap();
    for attempt in 0..20 {
        let path = folder.path().join(format!("{attempt}.mcap"));
        let running = Pipeline::prepare(vec![sensor("left", u64::MAX)]).start().unwrap();
        while running.handles()[0].counts().captured == 0 {
            std::thread::yield_now();
        }
        let subscription = running.subscriptions().subscribe(RecorderThread::interest());
        let recorder =
            RecorderThread::start(&path, running.handles(), subscription, RecorderOptions::default()).unwrap();
        while recorder.progress().frames < 3 {
            std::thread::yield_now();
        }
        assert_eq!(recorder.stop().error, None);
        let mut source = RecordingSource::open(Recording::open(&path).unwrap(), 0).unwrap();
        assert_eq!(source.next_frame().unwrap().unwrap().sequence, 0, "attempt {attempt}");
        running.stop();
    }
}

#[test]
fn a_recorder_that_is_stopped_closes_its_file_while_sensors_run() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mcap");
    let running = Pipeline::prepare(vec![sensor("left", u64::MAX)]).start().unwrap();
    let subscription = running.subscriptions().subscribe(RecorderThread::interest());
    let recorder = RecorderThread::start(&path, running.handles(), subscription, RecorderOptions::default()).unwrap();
    while recorder.progress().frames < 20 {
        std::thread::yield_now();
    }
    let progress = recorder.stop();
    assert!(!running.handles()[0].is_ended());
    running.stop();
    assert_eq!(progress.error, None);
    let recording = Recording::open(&path).unwrap();
    assert!(!recording.is_cut_off());
    assert_eq!(recording.sensors()[0].frames, progress.frames);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_named_at_the_start() {
    let pipeline = Pipeline::prepare(vec![sensor("left", 3)]);
    let subscription = pipeline.subscribe(RecorderThread::interest());
    let options = RecorderOptions::default();
    let error = RecorderThread::start(Path::new("/dev/full"), &pipeline.handles(), subscription, options).unwrap_err();
    assert!(matches!(error, RecordingError::Write { .. }) && error.hint().contains("free some space"), "{error}");
}

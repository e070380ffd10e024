use crate::film::{Film, SIZE};
use crate::until_the_end;
use fingervision_image::{Frame, Image, Pixels};
use fingervision_pipeline::{Input, Interest, Message, Pace, Pipeline, PipelineError, Sensor};
use fingervision_touch::{Fields, Flag, Profile, ReadingNumbers, Tracker};
use std::time::Duration;

fn sensor(name: &str, frames: Vec<Frame>, pace: Pace) -> Sensor {
    Sensor::open(name, Profile::default(), Input::source(Film::source(frames), pace), Fields::default()).unwrap()
}

/// Without the time that it took.
fn lasting(numbers: ReadingNumbers) -> ReadingNumbers {
    let mut lasting = numbers;
    lasting.latency_ms = 0.0;
    lasting
}

#[test]
fn the_same_frames_give_the_same_bits_as_offline() {
    let frames = Film::of(12, 30.0);
    let pipeline = Pipeline::prepare(vec![sensor("finger", frames.clone(), Pace::Lossless)]);
    let everything = Interest { frames: true, fields_every: Some(Duration::ZERO), capacity: 1000 };
    let subscription = pipeline.subscribe(everything);
    let running = pipeline.start().unwrap();
    let messages = until_the_end(&subscription);
    running.stop();

    let mut tracker = Tracker::new(&Profile::default(), SIZE, true, Fields::default()).unwrap();
    let offline: Vec<_> = frames.iter().map(|frame| tracker.track(frame).unwrap().clone()).collect();
    let numbers = messages.iter().filter_map(|message| match message {
        Message::Reading { numbers, .. } => Some(lasting(*numbers)),
        _ => None,
    });
    let numbers: Vec<_> = numbers.collect();
    assert_eq!(numbers, offline.iter().map(|reading| lasting(reading.numbers)).collect::<Vec<_>>());
    let mut compared = 0;
    for message in &messages {
        let Message::Fields { snapshot, .. } = message else { continue };
        let (live, offline) = (&snapshot.reading, &offline[snapshot.reading.sequence as usize]);
        assert_eq!(snapshot.frame.sequence, live.sequence);
        assert_eq!((&live.flow, &live.valid, &live.density), (&offline.flow, &offline.valid, &offline.density));
        assert_eq!(live.deviation, offline.deviation);
        compared += 1;
    }
    // Four snapshots can be held at the same time, and these are.
    assert_eq!(compared, 4);
    let captured = messages.iter().filter(|message| matches!(message, Message::Frame { .. })).count();
    assert_eq!(captured, frames.len());
}

#[test]
fn a_sensor_without_tracking_has_every_frame_and_no_readings() {
    // A thousand times faster than any tracker: none is dropped, as nothing tracks.
    let sensor = sensor("finger", Film::of(40, 1e6), Pace::Recorded).without_tracking();
    assert!(!sensor.handle().is_tracked());
    let pipeline = Pipeline::prepare(vec![sensor]);
    let subscription = pipeline.subscribe(Interest { frames: true, fields_every: Some(Duration::ZERO), capacity: 100 });
    let running = pipeline.start().unwrap();
    let messages = until_the_end(&subscription);
    let numbers: Vec<u64> = messages
        .iter()
        .filter_map(|message| match message {
            Message::Frame { frame, .. } => Some(frame.sequence),
            _ => None,
        })
        .collect();
    assert_eq!(numbers, (0..40).collect::<Vec<_>>());
    assert!(!messages.iter().any(|message| matches!(message, Message::Reading { .. } | Message::Fields { .. })));
    let counts = running.handles()[0].counts();
    assert_eq!((counts.captured, counts.tracked, counts.dropped), (40, 0, 0));
    assert!(running.handles()[0].is_ended());
}

#[test]
fn a_source_that_was_late_goes_on_at_its_rate() {
    const PERIOD_S: f64 = 0.02;
    let (source, open) = Film::gated(Film::of(10, 1.0 / PERIOD_S), 3);
    let input = Input::source(source, Pace::Recorded);
    let sensor = Sensor::open("finger", Profile::default(), input, Fields::default()).unwrap().without_tracking();
    let pipeline = Pipeline::prepare(vec![sensor]);
    let subscription = pipeline.subscribe(Interest { frames: true, fields_every: None, capacity: 100 });
    let running = pipeline.start().unwrap();
    std::thread::sleep(Duration::from_secs_f64(20.0 * PERIOD_S));
    open.send(()).unwrap();
    let captured_s = until_the_end(&subscription).into_iter().filter_map(|message| match message {
        Message::Frame { captured_s, .. } => Some(captured_s),
        _ => None,
    });
    let captured_s: Vec<f64> = captured_s.collect();
    running.stop();
    assert_eq!(captured_s.len(), 10);
    // A frame may be late by a period without moving those after it.
    for (periods, at_s) in (0..).zip(&captured_s[3..]) {
        let after_s = at_s - captured_s[3];
        assert!(after_s > PERIOD_S * f64::from(periods - 1), "frame {} came after {after_s:.3} s", 3 + periods);
    }
}

#[test]
fn frames_that_come_too_fast_are_dropped_counted_and_flagged() {
    // A thousand times faster than any tracker.
    let pipeline = Pipeline::prepare(vec![sensor("finger", Film::of(40, 1e6), Pace::Recorded)]);
    let subscription = pipeline.subscribe(Interest::readings());
    let running = pipeline.start().unwrap();
    let messages = until_the_end(&subscription);
    let counts = running.handles()[0].counts();
    assert_eq!(counts.captured, 40);
    assert!(counts.dropped > 10, "{counts:?}");
    assert_eq!(counts.tracked + counts.dropped, 40, "{counts:?}");
    let numbers = messages.iter().filter_map(|message| match message {
        Message::Reading { numbers, .. } => Some(*numbers),
        _ => None,
    });
    let last = numbers.clone().next_back().unwrap();
    assert_eq!((last.sequence, last.dropped_frames), (39, counts.dropped));
    assert!(numbers.clone().any(|numbers| numbers.flags.has(Flag::Dropped)));
}

#[test]
fn several_sensors_run_side_by_side() {
    let sensors =
        vec![sensor("left", Film::of(5, 30.0), Pace::Lossless), sensor("right", Film::of(7, 30.0), Pace::Lossless)];
    let pipeline = Pipeline::prepare(sensors);
    let subscription = pipeline.subscribe(Interest::readings());
    let running = pipeline.start().unwrap();
    let messages = until_the_end(&subscription);
    let count = |wanted: usize| {
        messages
            .iter()
            .filter(|message| matches!(message, Message::Reading { sensor, .. } if *sensor == wanted))
            .count()
    };
    assert_eq!((count(0), count(1)), (5, 7));
    assert_eq!(running.handles()[1].name(), "right");
    assert!(running.handles().iter().all(fingervision_pipeline::SensorHandle::is_ended));
}

#[test]
fn a_recording_is_played_at_its_own_rate() {
    let pipeline = Pipeline::prepare(vec![sensor("finger", Film::of(5, 50.0), Pace::Recorded)]);
    let subscription = pipeline.subscribe(Interest::readings());
    let running = pipeline.start().unwrap();
    let messages = until_the_end(&subscription);
    running.stop();
    let captured: Vec<f64> = messages
        .iter()
        .filter_map(|message| match message {
            Message::Reading { captured_s, .. } => Some(*captured_s),
            _ => None,
        })
        .collect();
    // Frames are never early.
    assert!(captured.len() >= 2 && captured.windows(2).all(|pair| pair[1] > pair[0]), "{captured:?}");
    assert!(captured[captured.len() - 1] - captured[0] > 0.07, "{captured:?}");
}

#[test]
fn a_frame_of_another_size_is_left_out_with_a_sentence() {
    let mut frames = Film::of(4, 30.0);
    frames[2].pixels = Pixels::Grey8(Image::filled(8, 8, 7));
    let pipeline = Pipeline::prepare(vec![sensor("finger", frames, Pace::Lossless)]);
    let subscription = pipeline.subscribe(Interest::readings());
    let running = pipeline.start().unwrap();
    let messages = until_the_end(&subscription);
    let event = messages.iter().find_map(|message| match message {
        Message::Event { text, .. } => Some(text.as_str()),
        _ => None,
    });
    let expected = "frame 2 is left out: frame 2 is 8x8 px, the previous frames were 96x80 px";
    assert_eq!(event, Some(expected));
    let counts = running.handles()[0].counts();
    assert_eq!((counts.tracked, counts.damaged), (3, 1));
}

#[test]
fn a_frame_that_cannot_be_read_is_counted_and_the_next_one_follows() {
    let input = Input::source(Film::damaged(Film::of(4, 30.0), 2), Pace::Lossless);
    let sensor = Sensor::open("finger", Profile::default(), input, Fields::default()).unwrap();
    let pipeline = Pipeline::prepare(vec![sensor]);
    let subscription = pipeline.subscribe(Interest::readings());
    let running = pipeline.start().unwrap();
    let messages = until_the_end(&subscription);
    let is_event = |message: &Message| matches!(message, Message::Event { text, .. } if text.contains("frame.png"));
    assert!(messages.iter().any(is_event));
    let counts = running.handles()[0].counts();
    assert_eq!((counts.tracked, counts.damaged), (3, 1));
}

#[test]
fn a_profile_that_does_not_fit_is_refused_before_the_start() {
    let mut profile = Profile::default();
    profile.set("image.region_of_interest", "[0, 0, 1000, 1000]").unwrap();
    let input = Input::source(Film::source(Film::of(2, 30.0)), Pace::Lossless);
    let error = Sensor::open("finger", profile, input, Fields::default()).err().unwrap();
    assert!(matches!(error, PipelineError::Track(_)), "{error}");
}

use crate::film::{Film, SIZE};
use crate::{LONG, until_the_end};
use fingervision_pipeline::{Input, Interest, Message, Pace, Pipeline, Sensor};
use fingervision_touch::{Fields, Flag, Profile, ReadingNumbers, Tracker};
use std::time::Duration;

/// The frame that is to become the reference.
const NEW: u64 = 5;

#[test]
fn a_new_reference_is_taken_when_asked_for_and_logged() {
    let frames = Film::of(10, 30.0);
    let (source, open) = Film::gated(frames.clone(), NEW);
    let input = Input::source(source, Pace::Lossless);
    let sensor = Sensor::open("finger", Profile::default(), input, Fields::default()).unwrap();
    let pipeline = Pipeline::prepare(vec![sensor]);
    let subscription =
        pipeline.subscribe(Interest { fields_every: Some(Duration::ZERO), capacity: 1000, ..Interest::readings() });
    let running = pipeline.start().unwrap();
    let is_before = |numbers: &ReadingNumbers| numbers.sequence + 1 == NEW;
    while !matches!(subscription.next(LONG), Some(Message::Reading { numbers, .. }) if is_before(&numbers)) {}
    running.handles()[0].rezero();
    open.send(()).unwrap();
    let messages = until_the_end(&subscription);

    let mut tracker = Tracker::new(&Profile::default(), SIZE, true, Fields::default()).unwrap();
    let fresh: Vec<_> = frames[NEW as usize..].iter().map(|frame| tracker.track(frame).unwrap().clone()).collect();
    let mut compared = 0;
    for message in &messages {
        let Message::Fields { snapshot, .. } = message else { continue };
        let reading = &snapshot.reading;
        let Some(step) = reading.sequence.checked_sub(NEW) else { continue };
        assert_eq!(reading.flow, fresh[step as usize].flow);
        assert_eq!(reading.flags.has(Flag::NewReference), step == 0, "{}", reading.flags);
        compared += 1;
    }
    assert!(compared > 0);
    let mut events = messages.iter().filter_map(|message| match message {
        Message::Event { text, .. } => Some(text.as_str()),
        _ => None,
    });
    assert_eq!((events.next(), events.next()), (Some("re-zeroed at frame 5"), None));
}

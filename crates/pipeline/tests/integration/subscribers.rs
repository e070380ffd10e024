use crate::film::Film;
use crate::{LONG, until_the_end};
use fingervision_pipeline::{Input, Interest, Message, Pace, Pipeline, Sensor};
use fingervision_touch::{Fields, Profile};
use std::time::Duration;

fn pipeline(frames: u64) -> Pipeline {
    let input = Input::source(Film::source(Film::of(frames, 30.0)), Pace::Lossless);
    Pipeline::prepare(vec![Sensor::open("finger", Profile::default(), input, Fields::NONE).unwrap()])
}

#[test]
fn a_slow_subscriber_loses_the_oldest_and_slows_nothing() {
    let pipeline = pipeline(20);
    let slow = pipeline.subscribe(Interest { frames: true, fields_every: Some(Duration::ZERO), capacity: 3 });
    let fast = pipeline.subscribe(Interest::readings());
    let running = pipeline.start().unwrap();
    // Nothing is read from `slow` until all is over.
    assert_eq!(until_the_end(&fast).len(), 21);
    assert_eq!((running.handles()[0].counts().tracked, fast.lost()), (20, 0));
    assert!(slow.lost() > 30, "{}", slow.lost());
    let left = until_the_end(&slow);
    assert_eq!(left.len(), 3);
    assert!(matches!(left[2], Message::End { sensor: 0 }));
}

#[test]
fn fields_are_copied_only_while_somebody_wants_them() {
    let pipeline = pipeline(20);
    let interest = Interest { fields_every: Some(Duration::ZERO), ..Interest::readings() };
    let (indifferent, wanting) = (pipeline.subscribe(Interest::readings()), pipeline.subscribe(interest));
    let running = pipeline.start().unwrap();
    let first = std::iter::from_fn(|| wanting.next(LONG)).find(|message| matches!(message, Message::Fields { .. }));
    assert!(first.is_some());
    wanting.set_fields_every(None);
    drop(first);
    let count =
        |messages: Vec<Message>| messages.iter().filter(|message| matches!(message, Message::Fields { .. })).count();
    assert_eq!(count(until_the_end(&indifferent)), 0);
    running.stop();
}

#[test]
fn who_subscribes_after_the_end_is_not_kept_waiting() {
    let pipeline = pipeline(2);
    let first = pipeline.subscribe(Interest::readings());
    let running = pipeline.start().unwrap();
    until_the_end(&first);
    let late = running.subscribe(Interest::readings());
    assert!(late.next(LONG).is_none() && late.is_done());
}

#[test]
fn a_subscriber_that_leaves_is_forgotten() {
    let pipeline = pipeline(10);
    let (stays, leaves) = (pipeline.subscribe(Interest::readings()), pipeline.subscribe(Interest::readings()));
    let running = pipeline.start().unwrap();
    drop(leaves);
    assert_eq!(until_the_end(&stays).len(), 11);
    running.stop();
}

#[test]
fn a_stop_ends_everything_in_order() {
    let input = Input::source(Film::source(Film::of(1000, 10.0)), Pace::Recorded);
    let sensor = Sensor::open("finger", Profile::default(), input, Fields::NONE).unwrap();
    let pipeline = Pipeline::prepare(vec![sensor]);
    let subscription = pipeline.subscribe(Interest::readings());
    let running = pipeline.start().unwrap();
    assert!(matches!(subscription.next(LONG), Some(Message::Reading { .. })));
    running.stop();
    let messages = until_the_end(&subscription);
    assert!(messages.len() < 100, "{}", messages.len());
    assert!(matches!(messages.last(), Some(Message::End { .. })));
}

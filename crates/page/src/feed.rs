//! The thread that converts messages of the sensors into those of the page.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use axum::body::Bytes;
use axum::extract::ws::Utf8Bytes;
use fingervision_pipeline::{Message, SensorHandle, Snapshot, Subscription, host_time_s};
use fingervision_touch::ReadingNumbers;
use serde::Serialize;

use crate::arrows::ArrowGrid;
use crate::picture::PictureCoder;
use crate::shared::Shared;
use crate::wire;

/// Time between two snapshots of a sensor.
const FIELDS_EVERY: Duration = Duration::from_millis(33);
/// Time between two pictures that have to be encoded here, s.
const PICTURE_EVERY_S: f64 = 0.1;
/// How often counts and the state of the recording are sent.
const STATE_S: f64 = 0.5;
/// How long the thread waits for a message.
const WAIT: Duration = Duration::from_millis(30);

/// Converts messages of the sensors into those of the page.
pub(crate) struct Feed {
    subscription: Subscription,
    handles: Vec<SensorHandle>,
    shared: Arc<Shared>,
    sensors: Vec<OneSensor>,
    state_sent_s: f64,
    has_pages: bool,
}

/// The state for the fields of one sensor.
#[derive(Default)]
struct OneSensor {
    arrows: Option<ArrowGrid>,
    coder: PictureCoder,
    picture_sent_s: f64,
}

/// The numbers of one reading, with short names because there are many.
#[derive(Debug, Serialize)]
struct Row {
    sensor: usize,
    sequence: u64,
    captured_s: f64,
    ready_s: f64,
    depth_mm: Option<f32>,
    area_mm2: Option<f32>,
    force_n: Option<[f32; 3]>,
    torque_nmm: Option<f32>,
    mean_level: f32,
    saturated: f32,
    sharpness: f32,
    flags: Vec<&'static str>,
}

#[derive(Debug, Serialize)]
struct State {
    now_s: f64,
    sensors: Vec<SensorState>,
    /// The file that is being written, and its bytes.
    recording: Option<(String, u64, f64)>,
}

#[derive(Debug, Serialize)]
struct SensorState {
    captured: u64,
    tracked: u64,
    dropped: u64,
    dropped_by_camera: u64,
    damaged: u64,
    restarts: u64,
    is_ended: bool,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "snake_case")]
enum Text<'a> {
    /// A list, because several readings can be sent together.
    Readings([Row; 1]),
    Event {
        sensor: usize,
        host_time_s: f64,
        text: &'a str,
    },
    State(State),
}

impl Row {
    fn new(sensor: usize, numbers: &ReadingNumbers, captured_s: f64, ready_s: f64) -> Self {
        Self {
            sensor,
            sequence: numbers.sequence,
            captured_s,
            ready_s,
            depth_mm: numbers.max_depth_mm,
            area_mm2: numbers.contact_area_mm2,
            force_n: numbers.force_n,
            torque_nmm: numbers.torque_nmm,
            mean_level: numbers.mean_level,
            saturated: numbers.saturated_part,
            sharpness: numbers.sharpness,
            flags: numbers.flags.iter().map(fingervision_touch::Flag::name).collect(),
        }
    }
}

impl Feed {
    pub(crate) fn new(subscription: Subscription, handles: Vec<SensorHandle>, shared: Arc<Shared>) -> Self {
        let sensors = handles.iter().map(|_| OneSensor::default()).collect();
        Self { subscription, handles, shared, sensors, state_sent_s: 0.0, has_pages: false }
    }

    pub(crate) fn run(mut self, is_stopped: &AtomicBool) {
        while !is_stopped.load(Ordering::Acquire) {
            self.look_for_pages();
            match self.subscription.next(WAIT) {
                Some(message) => self.take(message),
                None if self.subscription.is_done() => std::thread::sleep(WAIT),
                None => {}
            }
            let now_s = host_time_s();
            if now_s - self.state_sent_s >= STATE_S {
                self.state_sent_s = now_s;
                self.send_state(now_s);
            }
        }
    }

    /// Requests fields only while a page is open.
    fn look_for_pages(&mut self) {
        let has_pages = self.shared.has_pages();
        if has_pages != self.has_pages {
            self.has_pages = has_pages;
            self.subscription.set_fields_every(has_pages.then_some(FIELDS_EVERY));
        }
    }

    fn take(&mut self, message: Message) {
        if !self.has_pages {
            return;
        }
        match message {
            Message::Reading { sensor, numbers, captured_s, ready_s, .. } => {
                self.send(&Text::Readings([Row::new(sensor, &numbers, captured_s, ready_s)]));
            }
            Message::Fields { sensor, snapshot } => self.send_fields(sensor, &snapshot),
            Message::Event { sensor, host_time_s, text } => {
                self.send(&Text::Event { sensor, host_time_s, text: &text });
            }
            _ => {}
        }
    }

    fn send_fields(&mut self, index: usize, snapshot: &Snapshot) {
        let sensor = &mut self.sensors[index];
        let profile = self.handles[index].profile();
        let arrows = sensor.arrows.get_or_insert_with(|| ArrowGrid::new(profile, &snapshot.reading));
        let is_due = snapshot.ready_s - sensor.picture_sent_s >= PICTURE_EVERY_S;
        let picture = if is_due {
            sensor.picture_sent_s = snapshot.ready_s;
            sensor.coder.code(&snapshot.frame)
        } else {
            wire::Picture::default()
        };
        let message = wire::fields(index, snapshot, arrows, picture);
        self.shared.send_fields(Bytes::from(message));
    }

    fn send_state(&self, now_s: f64) {
        if !self.has_pages {
            return;
        }
        let of_sensor = |handle: &SensorHandle| {
            let counts = handle.counts();
            SensorState {
                captured: counts.captured,
                tracked: counts.tracked,
                dropped: counts.dropped,
                dropped_by_camera: counts.camera.dropped,
                damaged: counts.damaged + counts.camera.damaged,
                restarts: counts.camera.restarts,
                is_ended: handle.is_ended(),
            }
        };
        let recording = self.shared.actions.recording();
        let recording = recording.map(|(path, bytes, seconds)| (path.display().to_string(), bytes, seconds));
        self.send(&Text::State(State { now_s, sensors: self.handles.iter().map(of_sensor).collect(), recording }));
    }

    fn send(&self, text: &Text) {
        // Numbers and texts can always be written as JSON.
        if let Ok(json) = serde_json::to_string(text) {
            self.shared.send_text(Utf8Bytes::from(json));
        }
    }
}

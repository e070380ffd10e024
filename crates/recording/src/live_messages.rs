//! The messages of running sensors, for programs that show them while they come.

use std::io;

use fingervision_pipeline::Message;

use crate::RecordedSensor;
use crate::container::writer::Stamp;
use crate::sensor_messages::{MessageSink, SensorMessages, Times};
use crate::topic::{Topic, prefixes};
use crate::writer::messages_of;

/// Makes the messages that a recording also has, except the stored frames: pictures, readings, surfaces, truth, events,
/// the camera and the place of the gel.
#[derive(Debug)]
pub struct LiveMessages {
    sensors: Vec<RecordedSensor>,
    states: Vec<SensorMessages>,
    prefixes: Vec<String>,
    scratch: Vec<u8>,
}

/// A topic, and the schema of its messages.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct LiveChannel {
    /// The number by which messages refer to it.
    pub number: u16,
    /// Its name, as in a recording.
    pub topic: String,
    /// The full name of the schema.
    pub schema: &'static str,
    /// The descriptors of the schema: a protobuf `FileDescriptorSet`.
    pub descriptors: Vec<u8>,
}

/// Who takes live messages.
pub trait LiveSink {
    /// Whether anybody wants messages of this channel.
    fn wants(&self, channel: u16) -> bool;

    /// Takes an encoded message and its time, ns since 1970.
    fn take(&mut self, channel: u16, time_ns: u64, bytes: &[u8]);
}

impl LiveMessages {
    /// For these sensors, in the order of a pipeline.
    #[must_use]
    pub fn new(sensors: &[RecordedSensor]) -> Self {
        let prefixes = prefixes(sensors.iter().map(|sensor| sensor.name.as_str()));
        let states = messages_of(sensors, &prefixes);
        Self { sensors: sensors.to_vec(), states, prefixes, scratch: Vec::new() }
    }

    /// The channels of all sensors.
    #[must_use]
    pub fn channels(&self) -> Vec<LiveChannel> {
        let topics = Topic::ALL.into_iter().filter(|topic| *topic != Topic::Frame);
        let channel = |(sensor, prefix): (usize, &String), topic: Topic| LiveChannel {
            number: (sensor * Topic::ALL.len() + topic as usize) as u16,
            topic: topic.of(prefix),
            schema: topic.schema().name,
            descriptors: topic.schema().descriptors(),
        };
        let of_sensor = |sensor| topics.clone().map(move |topic| channel(sensor, topic));
        self.prefixes.iter().enumerate().flat_map(of_sensor).collect()
    }

    /// Sends the cameras and the places of the gels, which do not change: to be repeated for programs that come later.
    pub fn describe(&mut self, to: &mut impl LiveSink) {
        let to = &mut Encoded { to, scratch: &mut self.scratch };
        for (sensor, state) in self.sensors.iter().zip(&self.states) {
            // Memory takes every message.
            let _ = state.describe(&sensor.profile, sensor.frame_size, to);
        }
    }

    /// Sends what a message of a pipeline stands for.
    ///
    /// # Panics
    ///
    /// If it belongs to a sensor that was not given.
    pub fn send(&mut self, message: &Message, to: &mut impl LiveSink) {
        let to = &mut Encoded { to, scratch: &mut self.scratch };
        let states = &mut self.states;
        // Memory takes every message.
        let _ = match message {
            Message::Frame { sensor, frame, captured_s } => states[*sensor].picture(frame, *captured_s, to),
            Message::Reading { sensor, numbers, captured_s, .. } => states[*sensor].reading(numbers, *captured_s, to),
            Message::Fields { sensor, snapshot } => states[*sensor].surface(&snapshot.reading, snapshot.captured_s, to),
            Message::Truth { sensor, sequence, capture_time_s, captured_s, truth } => {
                let times = Times { captured_s: *captured_s, capture_time_s: *capture_time_s };
                states[*sensor].truth(*sequence, truth, times, to)
            }
            Message::Event { sensor, host_time_s, text } => states[*sensor].event(text, *host_time_s, to),
            _ => Ok(()),
        };
    }
}

/// Encodes messages into memory that is used again.
struct Encoded<'a, S> {
    to: &'a mut S,
    scratch: &'a mut Vec<u8>,
}

impl<S: LiveSink> MessageSink for Encoded<'_, S> {
    fn wants(&self, channel: u16) -> bool {
        self.to.wants(channel)
    }

    fn message(&mut self, stamp: Stamp, fill: impl FnOnce(&mut Vec<u8>)) -> io::Result<()> {
        if self.to.wants(stamp.channel) {
            self.scratch.clear();
            fill(self.scratch);
            self.to.take(stamp.channel, stamp.time_ns, self.scratch);
        }
        Ok(())
    }
}

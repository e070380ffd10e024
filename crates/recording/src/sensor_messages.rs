//! The messages of one sensor: what is written to a file, or sent to a program that listens.

use std::io;

use fingervision_optics::Camera;
use fingervision_source::{CameraCoding, EncodedFrame, FrameTruth};
use fingervision_touch::{Profile, Reading, ReadingNumbers};
use prost::Message;

use crate::container::writer::Stamp;
use crate::lossless::{Encoder, Storage};
use crate::message::{CompressedImage, Frame, Log, Truth, put_with_bytes, timestamp};
use crate::topic::Topic;
use crate::{Clock, RecordedSensor, coding, numbers, schema, view};

/// Time between two previews of a sensor, s.
const PREVIEW_PERIOD_S: f64 = 0.1;

/// Takes messages.
pub(crate) trait MessageSink {
    /// Whether messages of this channel are taken; those of others need not be made.
    fn wants(&self, channel: u16) -> bool;

    /// Takes a message; `fill` appends its bytes.
    fn message(&mut self, stamp: Stamp, fill: impl FnOnce(&mut Vec<u8>)) -> io::Result<()>;
}

/// When something happened.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Times {
    /// On the host's clock, s.
    pub(crate) captured_s: f64,
    /// On the source's clock, s.
    pub(crate) capture_time_s: f64,
}

/// Makes the messages of one sensor.
#[derive(Debug)]
pub(crate) struct SensorMessages {
    name: String,
    clock: Clock,
    /// The time 0 of the host's clock, s since 1970.
    host_start_s: f64,
    camera: Option<Camera>,
    /// The first channel; a channel for each topic follows.
    first_channel: u16,
    /// Number of image messages so far.
    images: u32,
    /// Time of the first frame, on the source's clock and on the host's, s.
    start_s: Option<[f64; 2]>,
    /// Time of the last message, ns.
    last_ns: u64,
    /// When the next preview is due, s.
    preview_due_s: f64,
    image: CompressedImage,
    frame: Frame,
    frame_ids: [String; 2],
}

impl SensorMessages {
    /// Sensor `index`, whose topics begin with `prefix`; `since_1970_s` is the time now, `host_now_s` on the host's clock.
    pub(crate) fn new(sensor: &RecordedSensor, prefix: &str, index: usize, since_1970_s: f64, host_now_s: f64) -> Self {
        let frame_ids = [format!("{prefix}/camera"), format!("{prefix}/gel")];
        let (format, frame_id) = ("jpeg".into(), frame_ids[0].clone());
        Self {
            name: sensor.name.clone(),
            clock: sensor.clock,
            host_start_s: since_1970_s - host_now_s,
            camera: sensor.profile.camera.and_then(|params| Camera::new(&params).ok()),
            first_channel: (Topic::ALL.len() * index) as u16,
            images: 0,
            start_s: None,
            last_ns: nanoseconds(since_1970_s),
            preview_due_s: 0.0,
            image: CompressedImage { format, frame_id, ..CompressedImage::default() },
            frame: Frame::default(),
            frame_ids,
        }
    }

    /// Time of the last message, ns since 1970.
    pub(crate) fn last_ns(&self) -> u64 {
        self.last_ns
    }

    /// The camera and the place of the gel.
    pub(crate) fn describe(
        &self,
        profile: &Profile,
        frame_size: (usize, usize),
        to: &mut impl MessageSink,
    ) -> io::Result<()> {
        let (time_ns, [camera_id, gel_id]) = (self.last_ns, &self.frame_ids);
        if let Some(message) = view::calibration(profile, frame_size, time_ns, camera_id) {
            to.message(self.stamp(Topic::Calibration, time_ns), |into| message.encode_raw(into))?;
        }
        if let Some(message) = view::transform(profile, time_ns, [camera_id, gel_id]) {
            to.message(self.stamp(Topic::Transform, time_ns), |into| message.encode_raw(into))?;
        }
        Ok(())
    }

    /// What is shown of a frame: the camera's own JPEG, or a small picture from time to time.
    pub(crate) fn picture(
        &mut self,
        frame: &EncodedFrame,
        captured_s: f64,
        to: &mut impl MessageSink,
    ) -> io::Result<()> {
        let time_ns = self.time_ns(frame_times(frame, captured_s));
        self.picture_at(time_ns, frame, to)
    }

    fn picture_at(&mut self, time_ns: u64, frame: &EncodedFrame, to: &mut impl MessageSink) -> io::Result<()> {
        if frame.layout.coding == CameraCoding::MotionJpeg {
            let stamp = self.stamp(Topic::Image, time_ns);
            if to.wants(stamp.channel) {
                self.image.timestamp = Some(timestamp(time_ns));
                to.message(stamp, |into| put_with_bytes(&self.image, 2, &frame.bytes, into))?;
                self.images += 1;
            }
            return Ok(());
        }
        let (stamp, time_s) = (self.stamp(Topic::Preview, time_ns), 1e-9 * time_ns as f64);
        if time_s >= self.preview_due_s && to.wants(stamp.channel) {
            self.preview_due_s = time_s + PREVIEW_PERIOD_S;
            if let Some(image) = view::preview(frame, time_ns, &self.frame_ids[0]) {
                to.message(stamp, |into| image.encode_raw(into))?;
            }
        }
        Ok(())
    }

    /// A frame bit by bit, with what is shown of it.
    pub(crate) fn frame(
        &mut self,
        frame: &EncodedFrame,
        captured_s: f64,
        encoder: &mut Encoder,
        to: &mut impl MessageSink,
    ) -> io::Result<()> {
        self.frame_at(frame_times(frame, captured_s), frame, captured_s, encoder, to)
    }

    /// As [`Self::frame`], with other times of the message than those of the frame in it.
    pub(crate) fn frame_at(
        &mut self,
        times: Times,
        frame: &EncodedFrame,
        captured_s: f64,
        encoder: &mut Encoder,
        to: &mut impl MessageSink,
    ) -> io::Result<()> {
        let (image, time_ns) = (self.images, self.time_ns(times));
        self.picture_at(time_ns, frame, to)?;
        let stamp = self.stamp(Topic::Frame, time_ns);
        if frame.layout.coding == CameraCoding::MotionJpeg {
            self.take_frame(frame, captured_s, time_ns, Storage::Image);
            self.frame.image = image;
            return to.message(stamp, |into| self.frame.encode_raw(into));
        }
        let (storage, stored) = encoder.encode(frame.layout, &frame.bytes);
        self.take_frame(frame, captured_s, time_ns, storage);
        to.message(stamp, |into| put_with_bytes(&self.frame, 13, stored, into))
    }

    /// What a simulation knows of a frame.
    pub(crate) fn truth(
        &mut self,
        sequence: u64,
        truth: &FrameTruth,
        times: Times,
        to: &mut impl MessageSink,
    ) -> io::Result<()> {
        let (time_ns, [force_x_n, force_y_n, force_z_n]) = (self.time_ns(times), truth.force_n);
        let message = Truth {
            timestamp: Some(timestamp(time_ns)),
            sequence,
            capture_time_s: times.capture_time_s,
            depth_mm: truth.depth_mm,
            force_x_n,
            force_y_n,
            force_z_n,
            torque_z_nmm: truth.torque_nmm,
        };
        self.put(Topic::Truth, time_ns, &message, to)
    }

    /// The numbers of a reading.
    pub(crate) fn reading(
        &mut self,
        numbers: &ReadingNumbers,
        captured_s: f64,
        to: &mut impl MessageSink,
    ) -> io::Result<()> {
        let time_ns = self.time_ns(Times { captured_s, capture_time_s: numbers.capture_time_s });
        if !to.wants(self.stamp(Topic::Reading, time_ns).channel) {
            return Ok(());
        }
        self.put(Topic::Reading, time_ns, &numbers::to_message(numbers, captured_s, time_ns), to)
    }

    /// The surface as points; nothing without depth or without a camera in the profile.
    pub(crate) fn surface(&mut self, reading: &Reading, captured_s: f64, to: &mut impl MessageSink) -> io::Result<()> {
        let time_ns = self.time_ns(Times { captured_s, capture_time_s: reading.capture_time_s });
        let Some(camera) = self.camera.as_ref().filter(|_| to.wants(self.stamp(Topic::Surface, time_ns).channel))
        else {
            return Ok(());
        };
        let Some(message) = view::surface(reading, camera, time_ns, &self.frame_ids[1]) else { return Ok(()) };
        self.put(Topic::Surface, time_ns, &message, to)
    }

    /// A sentence for the user.
    pub(crate) fn event(&mut self, text: &str, host_time_s: f64, to: &mut impl MessageSink) -> io::Result<()> {
        let time_ns = match self.clock {
            Clock::Host => nanoseconds(self.host_start_s + host_time_s),
            Clock::Source => self.last_ns,
        };
        let message = Log {
            timestamp: Some(timestamp(time_ns)),
            level: schema::INFO,
            message: text.into(),
            name: self.name.clone(),
            file: String::new(),
            line: 0,
        };
        self.put(Topic::Log, time_ns, &message, to)
    }

    fn put(&self, topic: Topic, time_ns: u64, message: &impl Message, to: &mut impl MessageSink) -> io::Result<()> {
        to.message(self.stamp(topic, time_ns), |into| message.encode_raw(into))
    }

    fn stamp(&self, topic: Topic, time_ns: u64) -> Stamp {
        Stamp { channel: self.first_channel + topic as u16, time_ns }
    }

    /// The time of a message about a frame with these times, ns since 1970.
    fn time_ns(&mut self, times: Times) -> u64 {
        let host_s = self.host_start_s + times.captured_s;
        let [first_s, start_s] = *self.start_s.get_or_insert([times.capture_time_s, host_s]);
        self.last_ns = match self.clock {
            Clock::Host => nanoseconds(host_s),
            Clock::Source => nanoseconds(start_s + times.capture_time_s - first_s),
        };
        self.last_ns
    }

    /// Describes a frame; its bytes come behind.
    fn take_frame(&mut self, frame: &EncodedFrame, captured_s: f64, time_ns: u64, storage: Storage) {
        let layout = frame.layout;
        let message = &mut self.frame;
        message.timestamp = Some(timestamp(time_ns));
        message.sequence = frame.sequence;
        (message.capture_time_s, message.captured_s) = (frame.capture_time_s, captured_s);
        (message.width, message.height) = (layout.width as u32, layout.height as u32);
        message.row_bytes = layout.row_bytes as u32;
        for (text, name) in [(&mut message.coding, coding::name(layout.coding)), (&mut message.storage, storage.name())]
        {
            text.clear();
            text.push_str(name);
        }
        message.image = 0;
        message.length = frame.bytes.len() as u64;
        message.crc32 = crc32fast::hash(&frame.bytes);
    }
}

fn frame_times(frame: &EncodedFrame, captured_s: f64) -> Times {
    Times { captured_s, capture_time_s: frame.capture_time_s }
}

fn nanoseconds(time_s: f64) -> u64 {
    (1e9 * time_s).round() as u64
}

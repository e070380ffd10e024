//! A small recording that the tests read.

use std::path::Path;

use fingervision_recording::{Clock, RecordedSensor, RecordingWriter};
use fingervision_source::{CameraCoding, CameraLayout, EncodedFrame};
use fingervision_touch::{Flag, Profile, ReadingNumbers};

/// Columns and rows of all frames, px.
pub(crate) const SIZE: (usize, usize) = (48, 32);

/// A JPEG picture of these tests' size.
pub(crate) const JPEG: &[u8] = include_bytes!("grey-48x32.jpg");

pub(crate) fn profile() -> Profile {
    let text = "name = \"left\"\n[camera]\nfocal_length_px = [40, 40]\nprincipal_point_px = [24, 16]\n\
                translation_mm = [0, 0, 20]\n[gel]\nsize_mm = [20, 16]\nthickness_mm = 4\npoissons_ratio = 0.48";
    Profile::from_toml(text).unwrap()
}

pub(crate) fn sensor(name: &str) -> RecordedSensor {
    RecordedSensor {
        name: name.into(),
        description: format!("camera {name}"),
        profile: profile(),
        frame_size: SIZE,
        clock: Clock::Host,
    }
}

/// Frame `number` of a sensor: JPEG for sensor 0, otherwise a coding that changes from frame to frame. Numbers have a gap.
pub(crate) fn frame(sensor: usize, number: u64) -> EncodedFrame {
    let (width, height) = SIZE;
    let (coding, len, row_bytes) = match (sensor, number % 4) {
        (0, _) => (CameraCoding::MotionJpeg, 0, 0),
        (_, 0) => (CameraCoding::Yuyv { is_full_range: true }, 2 * width * height, 0),
        (_, 1) => (CameraCoding::Rgb16, 6 * width * height, 0),
        (_, 2) => (CameraCoding::Grey8, 64 * height, 64),
        _ => (CameraCoding::Rgb8, 3 * width * height, 0),
    };
    let bytes = match coding {
        CameraCoding::MotionJpeg => [JPEG, &number.to_le_bytes()].concat(),
        _ => (0..len).map(|index| (index / 5 + index % 3 * number as usize) as u8).collect(),
    };
    let layout = CameraLayout { coding, width, height, row_bytes };
    let sequence = 1000 + number + number / 3;
    EncodedFrame { sequence, capture_time_s: 0.1 * number as f64 + 1.0 / 3.0, layout, bytes }
}

pub(crate) fn reading(number: u64) -> ReadingNumbers {
    let mut numbers = ReadingNumbers::default();
    (numbers.sequence, numbers.capture_time_s) = (1000 + number, 0.1 * number as f64);
    numbers.force_n = number.is_multiple_of(2).then_some([0.1, 0.2, number as f32]);
    numbers.flags.raise(Flag::Dropped);
    numbers
}

/// Two sensors with this many frames and readings, and an event each.
pub(crate) fn write(path: &Path, frames: u64) -> RecordingWriter {
    let mut writer = RecordingWriter::create(path, &[sensor("left"), sensor("right index")]).unwrap();
    for number in 0..frames {
        for index in 0..2 {
            let captured_s = 50.0 + 0.01 * number as f64;
            writer.write_frame(index, &frame(index, number), captured_s).unwrap();
            writer.write_reading(index, &reading(number), captured_s).unwrap();
        }
    }
    writer.write_event(1, "unplugged", 51.0).unwrap();
    writer
}

pub(crate) fn bytes(frames: u64) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mcap");
    write(&path, frames).finish().unwrap();
    std::fs::read(path).unwrap()
}

//! Written data are read back, bit for bit, from whole and from cut-off files.

use std::fs;
use std::path::Path;

use fingervision_recording::{Recording, RecordingError, RecordingSource, RecordingWriter};
use fingervision_source::{EncodedFrame, FrameTruth, Source, SourceError};

use crate::written;

fn frames(recording: &Recording, sensor: usize) -> Vec<EncodedFrame> {
    let mut source = RecordingSource::open(recording.clone(), sensor).unwrap();
    let mut frames = Vec::new();
    let mut frame = EncodedFrame::empty();
    while source.next_encoded(&mut frame).unwrap() {
        frames.push(frame.clone());
    }
    frames
}

fn file(folder: &Path, bytes: &[u8]) -> std::path::PathBuf {
    let path = folder.join("x.mcap");
    fs::write(&path, bytes).unwrap();
    path
}

#[test]
fn frames_readings_events_and_profiles_come_back_as_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let recording = Recording::open(&file(folder.path(), &written::bytes(9))).unwrap();
    assert!(!recording.is_cut_off() && recording.remarks().is_empty());
    for sensor in 0..2 {
        let expected: Vec<EncodedFrame> = (0..9).map(|number| written::frame(sensor, number)).collect();
        assert_eq!(frames(&recording, sensor), expected);
        assert_eq!(recording.readings(sensor).unwrap(), (0..9).map(written::reading).collect::<Vec<_>>());
        assert_eq!(recording.profile(sensor).unwrap(), Some(written::profile()));
    }
    let [left, right] = recording.sensors() else { panic!("two sensors") };
    assert_eq!((left.name.as_str(), right.name.as_str()), ("left", "right index"));
    assert_eq!((left.frames, left.readings, left.events, right.events), (9, 9, 0, 1));
    assert!((left.duration_s - 0.08).abs() < 1e-6, "{}", left.duration_s);
    assert_eq!(recording.events(1).unwrap(), ["unplugged"]);
}

#[test]
fn a_recording_is_a_source_of_pixels() {
    let folder = tempfile::tempdir().unwrap();
    let recording = Recording::open(&file(folder.path(), &written::bytes(4))).unwrap();
    let mut source = RecordingSource::open(recording.clone(), 0).unwrap();
    assert_eq!((source.size(), source.frame_count(), source.last_sequence()), (written::SIZE, Some(4), Some(1004)));
    let frame = source.next_frame().unwrap().unwrap();
    assert_eq!((frame.sequence, frame.capture_time_s, frame.pixels.size()), (1000, 1.0 / 3.0, written::SIZE));
    // The other sensor's frames change their format: an error, after which the source can go on.
    let mut source = RecordingSource::open(recording, 1).unwrap();
    assert!(source.next_frame().is_ok());
    assert!(matches!(source.next_frame(), Err(SourceError::FormatChanged { sequence: 1001, .. })));
    assert!(matches!(source.next_frame(), Ok(None)));
    assert!(source.resume());
    assert!(matches!(source.next_frame(), Ok(Some(frame)) if frame.sequence == 1002), "grey as the first");
    assert!(matches!(source.next_frame(), Err(SourceError::FormatChanged { sequence: 1004, .. })));
}

#[test]
fn a_recording_that_was_not_closed_gives_what_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mcap");
    let writer = written::write(&path, 800);
    assert_eq!(writer.bytes_written(), fs::metadata(&path).unwrap().len());
    std::mem::forget(writer);
    let recording = Recording::open(&path).unwrap();
    assert!(recording.is_cut_off() && recording.remarks()[0].contains("was not closed"));
    let frames = frames(&recording, 0);
    assert!((1..800).contains(&frames.len()), "{} frames: the last chunk is in memory", frames.len());
    let expected: Vec<EncodedFrame> = (0..frames.len() as u64).map(|number| written::frame(0, number)).collect();
    assert!(frames == expected);
}

#[test]
fn every_cut_opens_or_says_what_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = written::bytes(4);
    let mut counts = Vec::new();
    for len in (0..bytes.len()).step_by(61) {
        match Recording::open(&file(folder.path(), &bytes[..len])) {
            Ok(recording) => counts.push(recording.sensors().iter().map(|sensor| sensor.frames).sum::<u64>()),
            Err(RecordingError::NotARecording { .. }) => assert!(counts.is_empty(), "{len}"),
            Err(error) => panic!("{len}: {error}"),
        }
    }
    assert!(counts.is_sorted() && counts.first() == Some(&0) && counts.last() == Some(&8), "{counts:?}");
}

#[test]
fn one_of_several_sensors_must_be_named() {
    let folder = tempfile::tempdir().unwrap();
    let recording = Recording::open(&file(folder.path(), &written::bytes(2))).unwrap();
    assert_eq!(recording.sensor(Some("right index")).unwrap(), 1);
    for name in [None, Some("middle")] {
        let error = recording.sensor(name).unwrap_err();
        assert!(error.to_string().contains("left, right index") && error.hint().contains("?sensor=left"), "{error}");
    }
}

#[test]
fn a_damaged_frame_is_an_error_and_the_next_one_follows() {
    let folder = tempfile::tempdir().unwrap();
    let mut bytes = written::bytes(4);
    // A byte of the third picture of sensor 0: its last eight bytes are its number.
    let picture = [&written::JPEG[written::JPEG.len() - 20..], &2_u64.to_le_bytes()].concat();
    let at = bytes.windows(picture.len()).position(|window| window == picture).unwrap();
    bytes[at] ^= 1;
    let recording = Recording::open(&file(folder.path(), &bytes)).unwrap();
    let mut source = RecordingSource::open(recording, 0).unwrap();
    let mut numbers = Vec::new();
    loop {
        match source.next_frame() {
            Ok(Some(frame)) => numbers.push(frame.sequence),
            Ok(None) => break,
            Err(SourceError::Frame { sequence, reason, .. }) => {
                assert_eq!((sequence, reason.as_str()), (1002, "its bytes are damaged"));
                assert!(source.resume());
            }
            Err(error) => panic!("{error}"),
        }
    }
    assert_eq!(numbers, [1000, 1001, 1004]);
}

#[test]
fn a_reading_of_a_chunk_whose_sum_is_wrong_is_left_out() {
    // Two chunks and a part of a third; how full a chunk is depends on the clock, by some bytes.
    const READINGS: usize = 1000;
    let folder = tempfile::tempdir().unwrap();
    let whole = written::bytes(READINGS as u64);
    let sound = Recording::open(&file(folder.path(), &whole)).unwrap().readings(1).unwrap();
    assert_eq!(sound.len(), READINGS);
    // A byte of the time of reading 5, which only readings have: the file stays readable, the chunk's sum is wrong.
    let mut bytes = whole.clone();
    let time = 0.5_f64.to_le_bytes();
    let at = bytes.windows(8).position(|window| window == time).unwrap();
    bytes[at] ^= 1;
    let recording = Recording::open(&file(folder.path(), &bytes)).unwrap();
    let left = recording.readings(1).unwrap();
    assert!((1..READINGS).contains(&left.len()), "{} readings", left.len());
    // Those that are left are right, and the frames of the damaged chunk have sums of their own.
    assert_eq!(left, sound[sound.len() - left.len()..]);
    assert_eq!(frames(&recording, 0), frames(&Recording::open(&file(folder.path(), &whole)).unwrap(), 0));
}

#[test]
fn the_truth_of_a_simulation_comes_back_and_is_part_of_the_source() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mcap");
    let mut writer = RecordingWriter::create(&path, &[written::sensor("left"), written::sensor("right")]).unwrap();
    writer.write_scene(0, "name = \"letter\"").unwrap();
    let truth = |number: u64| {
        let depth_mm = 0.1 * number as f64;
        FrameTruth { depth_mm, force_n: [0.0, -depth_mm, 1.0 / 3.0], torque_nmm: -depth_mm }
    };
    for number in 0..5 {
        let (frame, captured_s) = (written::frame(0, number), 50.0 + 0.1 * number as f64);
        writer.write_frame(0, &frame, captured_s).unwrap();
        writer.write_truth(0, (frame.sequence, frame.capture_time_s), &truth(number), captured_s).unwrap();
    }
    writer.finish().unwrap();
    let recording = Recording::open(&path).unwrap();
    let truths = recording.truths(0).unwrap();
    assert_eq!(truths.iter().map(|recorded| recorded.truth).collect::<Vec<_>>(), (0..5).map(truth).collect::<Vec<_>>());
    assert_eq!(truths.iter().map(|recorded| recorded.sequence).collect::<Vec<_>>(), [1000, 1001, 1002, 1004, 1005]);
    assert_eq!((recording.scene_toml(0), recording.scene_toml(1)), (Some("name = \"letter\""), None));
    assert!(recording.truths(1).unwrap().is_empty());
    let mut source = RecordingSource::open(recording, 0).unwrap();
    source.next_frame().unwrap();
    source.next_frame().unwrap();
    assert_eq!((source.truth(), source.scene_toml().as_deref()), (Some(truth(1)), Some("name = \"letter\"")));
}

#[test]
fn other_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for bytes in [b"".as_slice(), b"\x89MCAP0\r\n", b"RIFF and more than that"] {
        let error = Recording::open(&file(folder.path(), bytes)).unwrap_err();
        assert!(matches!(error, RecordingError::NotARecording { .. }), "{error}");
    }
    assert!(matches!(Recording::open(Path::new("/absent.mcap")), Err(RecordingError::Read { .. })));
}

//! Mutated recordings: no panic, no memory without bound.

use std::fs;

use fingervision_fuzz::{Form, Parser};
use fingervision_recording::{Recording, RecordingSource};
use fingervision_source::Source;

use crate::written;

#[test]
fn recordings() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mcap");
    let files = vec![written::bytes(2), written::bytes(5)];
    let parser = Parser { name: "recordings", form: Form::Binary, files, inputs: 400, most_bytes: 64 << 20 };
    parser.run(|bytes| {
        fs::write(&path, bytes).unwrap();
        let Ok(recording) = Recording::open(&path) else { return false };
        (0..recording.sensors().len()).all(|sensor| read(&recording, sensor))
    });
}

/// Reads everything of a sensor; damaged frames are skipped.
fn read(recording: &Recording, sensor: usize) -> bool {
    let numbers = recording.readings(sensor).and_then(|_| recording.events(sensor));
    let has_profile = recording.profile(sensor).is_ok();
    let Ok(mut source) = RecordingSource::open(recording.clone(), sensor) else { return false };
    for _ in 0..source.frame_count().unwrap_or_default() {
        if source.next_frame().is_err() {
            source.resume();
        }
    }
    numbers.is_ok() && has_profile
}

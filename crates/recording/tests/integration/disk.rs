//! A disk that becomes full.

use std::io::{self, Write};
use std::sync::{Arc, Mutex};
use std::{fs, iter};

use fingervision_recording::{Recording, RecordingError, RecordingSource, RecordingWriter};

use crate::written;

/// A disk that has this much space.
#[derive(Clone)]
struct SmallDisk {
    bytes: Arc<Mutex<Vec<u8>>>,
    space: usize,
}

impl Write for SmallDisk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut kept = self.bytes.lock().unwrap();
        let len = bytes.len().min(self.space - kept.len());
        if len == 0 {
            return Err(io::ErrorKind::StorageFull.into());
        }
        kept.extend_from_slice(&bytes[..len]);
        Ok(len)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_full_disk_ends_a_recording_with_one_error_and_keeps_what_was_written() {
    let disk = SmallDisk { bytes: Arc::default(), space: 1_500_000 };
    let path = std::path::Path::new("small/x.mcap");
    let mut writer = RecordingWriter::new(disk.clone(), path, &[written::sensor("left")]).unwrap();
    let write = |number| writer.write_frame(0, &written::frame(0, number), number as f64).err();
    let errors: Vec<RecordingError> = (0..4000).map(write).skip_while(Option::is_none).map(Option::unwrap).collect();
    let first = errors.first().unwrap();
    assert!(first.to_string().contains("small/x.mcap: cannot be written") && first.hint().contains("free some space"));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mcap");
    fs::write(&path, disk.bytes.lock().unwrap().as_slice()).unwrap();
    let recording = Recording::open(&path).unwrap();
    assert!(recording.is_cut_off());
    let mut source = RecordingSource::open(recording, 0).unwrap();
    let mut frame = fingervision_source::EncodedFrame::empty();
    let frames: Vec<_> = iter::from_fn(|| source.next_encoded(&mut frame).unwrap().then(|| frame.clone())).collect();
    assert!(frames.len() > 500, "{}", frames.len());
    assert!(frames.iter().zip(0..).all(|(frame, number)| *frame == written::frame(0, number)));
}

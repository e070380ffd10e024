//! The recording of the soak, read from start to end.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use fingervision_recording::{Recording, RecordingSource};
use fingervision_source::EncodedFrame;

/// The frames of a sensor in a recording.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Recorded {
    pub(super) sensor: String,
    /// The numbers of its frames.
    pub(super) sequences: Vec<u64>,
}

/// Opens a recording and reads every frame; each is compared with its check sum.
pub(super) fn read(path: &Path) -> Result<Vec<Recorded>> {
    let recording = Recording::open(path)?;
    ensure!(!recording.is_cut_off(), "{}: the recording is cut off", path.display());
    let mut all = Vec::new();
    for (index, sensor) in recording.sensors().iter().enumerate() {
        let named = || format!("{}, sensor {}", path.display(), sensor.name);
        let mut source = RecordingSource::open(recording.clone(), index).with_context(named)?;
        let (mut frame, mut sequences) = (EncodedFrame::empty(), Vec::new());
        while source.next_encoded(&mut frame).with_context(named)? {
            sequences.push(frame.sequence);
        }
        all.push(Recorded { sensor: sensor.name.clone(), sequences });
    }
    Ok(all)
}

impl Recorded {
    /// Frames that are missing, of a source that has delivered this many.
    ///
    /// The first frame of a file is the reference; those between it and the begin of the recording are not missing.
    pub(super) fn missing(&self, captured: u64) -> u64 {
        let (Some(first), Some(last)) = (self.sequences.get(1), self.sequences.last()) else { return captured };
        let expected = captured.max(last + 1).saturating_sub(*first);
        expected.saturating_sub(self.sequences.len() as u64 - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn missing(sequences: &[u64], captured: u64) -> u64 {
        Recorded { sensor: "left".into(), sequences: sequences.to_vec() }.missing(captured)
    }

    #[test]
    fn frames_are_missing_where_numbers_are_skipped_and_at_the_end() {
        assert_eq!(missing(&[0, 1, 2, 3], 4), 0);
        // The recording began at frame 7.
        assert_eq!(missing(&[0, 7, 8, 9], 10), 0);
        assert_eq!(missing(&[0, 7, 9, 12], 13), 3);
        assert_eq!(missing(&[0, 1, 2], 5), 2);
        // A frame that arrived after the count.
        assert_eq!(missing(&[0, 1, 2, 3], 3), 0);
    }

    #[test]
    fn of_a_recording_without_frames_all_are_missing() {
        assert_eq!(missing(&[], 5), 5);
        assert_eq!(missing(&[0], 5), 5);
    }
}

//! What the soak has measured beside what is asked.

use fingervision_evaluate::quantile;

use super::live::Ended;
use super::memory::{Memory, Range};
use super::recorded::Recorded;
use crate::performance::table;

/// The most that the memory may vary after warming up, as a part of its least value.
const MOST_SPREAD: f64 = 0.05;

/// The result of a soak.
#[derive(Debug)]
pub(super) struct Report {
    sensors: Vec<Sensor>,
    warm_up_s: f64,
    memory: Option<Range>,
    /// Median and 99th percentile of the time from capture to the page, ms; NaN without a page.
    latencies_ms: [f64; 2],
}

#[derive(Debug)]
struct Sensor {
    ended: Ended,
    /// Frames in the recording, if there is one.
    recorded: Option<usize>,
    /// Frames missing there.
    missing: u64,
}

impl Report {
    pub(super) fn new(
        ended: &[Ended],
        recorded: Option<&[Recorded]>,
        memory: &Memory,
        warm_up_s: f64,
        latencies_ms: &[f32],
    ) -> Self {
        let of_sensor = |ended: &Ended| {
            let ended = ended.clone();
            let Some(recorded) = recorded else { return Sensor { ended, recorded: None, missing: 0 } };
            let found = recorded.iter().find(|recorded| recorded.sensor == ended.sensor);
            let missing = found.map_or(ended.frames, |found| found.missing(ended.frames));
            Sensor { ended, recorded: Some(found.map_or(0, |found| found.sequences.len())), missing }
        };
        Self {
            sensors: ended.iter().map(of_sensor).collect(),
            warm_up_s,
            memory: memory.range(warm_up_s),
            latencies_ms: [0.5, 0.99].map(|part| quantile(latencies_ms.iter().copied(), part)),
        }
    }

    /// A Markdown table.
    pub(super) fn table(&self) -> String {
        let mut rows = Vec::new();
        for Sensor { ended, recorded, missing } in &self.sensors {
            let Ended {
                sensor,
                frames,
                readings,
                frames_per_second,
                dropped_by_camera,
                dropped_before_tracking,
                damaged,
            } = ended;
            let rate = frames_per_second.map_or("not known".to_owned(), |rate| format!("{rate:.2}"));
            let mut add = |what: &str, asked: &str, measured: String| {
                rows.push(vec![format!("{sensor}: {what}"), asked.to_owned(), measured]);
            };
            add("frames; readings", "–", format!("{frames}; {readings}"));
            add("readings per second", "–", rate);
            add("dropped before tracking", "0", dropped_before_tracking.to_string());
            add("dropped by the camera; damaged", "–", format!("{dropped_by_camera}; {damaged}"));
            if let Some(recorded) = recorded {
                add("missing in the recording", "0", format!("{missing}; {recorded} are in it"));
            }
        }
        let memory = self.memory.map_or("not measured".to_owned(), |range| {
            let [least, most] = [range.least_bytes, range.most_bytes].map(|bytes| bytes as f64 / 1e6);
            format!("{least:.1} to {most:.1} MB, {:.1} %", 100.0 * range.spread())
        });
        let asked = format!("within {:.0} %", 100.0 * MOST_SPREAD);
        rows.push(vec![format!("memory after {:.0} s", self.warm_up_s), asked, memory]);
        if let [p50, p99] = self.latencies_ms
            && p50.is_finite()
        {
            rows.push(vec!["capture to page, p50; p99".into(), "–".into(), format!("{p50:.1}; {p99:.1} ms")]);
        }
        table(&["", "asked", "measured"], &rows)
    }

    /// What is not as asked.
    pub(super) fn faults(&self) -> Vec<String> {
        let mut faults = Vec::new();
        for Sensor { ended, missing, .. } in &self.sensors {
            let Ended { sensor, frames, dropped_before_tracking: dropped, .. } = ended;
            if *dropped > 0 {
                faults.push(format!(
                    "{sensor}: {dropped} of {frames} frames were dropped before tracking; is the machine idle, and fast \
                     enough for this --rate?"
                ));
            }
            if *missing > 0 {
                faults.push(format!("{sensor}: {missing} of {frames} frames are missing in the recording"));
            }
        }
        match self.memory {
            Some(range) if range.spread() > MOST_SPREAD => {
                let [least, most] = [range.least_bytes, range.most_bytes].map(|bytes| bytes as f64 / 1e6);
                let after = self.warm_up_s;
                faults.push(format!("memory was {least:.1} to {most:.1} MB after the first {after:.0} s"));
            }
            Some(_) => {}
            None => faults.push("memory was not measured: the run was too short".into()),
        }
        faults
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(dropped: u64, last: u64, bytes: [u64; 2]) -> Report {
        let sensor = "left".to_owned();
        let ended = Ended {
            sensor: sensor.clone(),
            frames: 20,
            readings: 20 - dropped,
            frames_per_second: Some(10.0),
            dropped_by_camera: 0,
            dropped_before_tracking: dropped,
            damaged: 0,
        };
        let recorded = Recorded { sensor, sequences: (0..=last).collect() };
        let mut memory = Memory::default();
        memory.add(1.0, 1);
        for bytes in bytes {
            memory.add(10.0, bytes);
        }
        Report::new(&[ended], Some(&[recorded]), &memory, 5.0, &[10.0, 11.0, 30.0])
    }

    #[test]
    fn a_run_as_asked_has_no_fault() {
        let report = report(0, 19, [100_000_000, 104_000_000]);
        assert_eq!(report.faults(), Vec::<String>::new());
        let table = report.table();
        assert!(table.contains("| left: missing in the recording | 0 | 0; 20 are in it |"), "{table}");
        assert!(table.contains("| memory after 5 s | within 5 % | 100.0 to 104.0 MB, 4.0 % |"), "{table}");
        assert!(table.contains("| capture to page, p50; p99 | – | 11.0; 30.0 ms |"), "{table}");
    }

    #[test]
    fn every_fault_is_named_with_its_value() {
        let faults = report(3, 16, [100_000_000, 106_000_000]).faults();
        assert_eq!(faults.len(), 3, "{faults:?}");
        assert!(faults[0].starts_with("left: 3 of 20 frames were dropped before tracking"), "{}", faults[0]);
        assert_eq!(faults[1], "left: 3 of 20 frames are missing in the recording");
        assert_eq!(faults[2], "memory was 100.0 to 106.0 MB after the first 5 s");
    }

    #[test]
    fn without_a_recording_nothing_is_missing() {
        let mut report = report(0, 19, [100, 100]);
        let ended = report.sensors.remove(0).ended;
        let other = Report::new(&[ended], None, &Memory::default(), 5.0, &[]);
        assert_eq!(other.faults(), ["memory was not measured: the run was too short"]);
        assert!(!other.table().contains("recording"), "{}", other.table());
        // Nor has a page received anything.
        assert!(!other.table().contains("page"), "{}", other.table());
    }

    #[test]
    fn a_sensor_that_is_not_in_the_recording_is_a_fault() {
        let mut report = report(0, 19, [100, 100]);
        let ended = report.sensors.remove(0).ended;
        let other = Report::new(&[ended], Some(&[]), &Memory::default(), 5.0, &[]);
        assert_eq!(other.faults()[0], "left: 20 of 20 frames are missing in the recording");
        assert_eq!(other.faults()[1], "memory was not measured: the run was too short");
    }
}

//! The committed record of instruction counts, and how new counts compare with it.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};

use super::stage::Stage;

/// The largest rise that passes, as part of the recorded value.
const MOST_RISE: f64 = 0.03;

/// Counts and errors of all stages on one instruction set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Record {
    pub(crate) instruction_set: String,
    /// The processor on which it was made; the counts do not depend on it.
    pub(crate) processor: String,
    pub(crate) rustc: String,
    pub(crate) valgrind: String,
    /// Columns and rows of the frames, px.
    pub(crate) size: [usize; 2],
    pub(crate) stages: Vec<Entry>,
}

/// One stage, per frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Entry {
    pub(crate) stage: Stage,
    pub(crate) instructions: u64,
    /// Bytes between the first and the second cache.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) first_cache_bytes: Option<u64>,
    /// Bytes between the second cache and what lies behind it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) second_cache_bytes: Option<u64>,
    /// Mean error of its output against the truth.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) error: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) unit: Option<String>,
}

/// How counts compare with a record.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Comparison {
    /// A line per stage.
    pub(super) lines: Vec<String>,
    /// What rose too far, in words.
    pub(super) faults: Vec<String>,
    /// Stages that fell so far that a new record is worth it.
    pub(super) fallen: usize,
}

impl Record {
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let text = fs::read_to_string(path).with_context(|| format!("{} cannot be read", path.display()))?;
        serde_json::from_str(&text).with_context(|| format!("{} is not a record of instructions", path.display()))
    }

    pub(super) fn write(&self, path: &Path) -> Result<()> {
        let text = serde_json::to_string_pretty(self)? + "\n";
        fs::write(path, text).with_context(|| format!("{} cannot be written", path.display()))
    }

    pub(crate) fn entry(&self, stage: Stage) -> Option<&Entry> {
        self.stages.iter().find(|entry| entry.stage == stage)
    }

    /// Compares new counts with these.
    pub(super) fn compare(&self, counted: &[Entry]) -> Comparison {
        let mut comparison = Comparison::default();
        for new in counted {
            let Some(old) = self.entry(new.stage) else {
                comparison.faults.push(format!("{} is not in the record", new.stage));
                continue;
            };
            let change = change(old.instructions as f64, new.instructions as f64);
            let mut line = format!("{new}  {:+.2} %", 100.0 * change);
            if change > MOST_RISE {
                comparison.faults.push(format!(
                    "{} takes {:.2} M instructions a frame, {:.2} M before: {:.1} % more",
                    new.stage,
                    millions(new.instructions),
                    millions(old.instructions),
                    100.0 * change
                ));
            }
            comparison.fallen += usize::from(change < -MOST_RISE);
            let errors = [old.error, new.error].map(|error| error.filter(|error| error.is_finite()));
            if let ([Some(before), Some(now)], Some(unit)) = (errors, &new.unit) {
                let change = self::change(before, now);
                let _ = write!(line, ", error {:+.2} %", 100.0 * change);
                if change > MOST_RISE {
                    let percent = 100.0 * change;
                    comparison.faults.push(format!(
                        "{} has an error of {now:.5} {unit}, {before:.5} {unit} before: {percent:.1} % more",
                        new.stage
                    ));
                }
            } else if let Some(unit) = &new.unit {
                comparison.faults.push(format!("{} has no error in {unit} to compare", new.stage));
            }
            comparison.lines.push(line);
        }
        let missing = self.stages.iter().filter(|old| counted.iter().all(|new| new.stage != old.stage));
        comparison.faults.extend(missing.map(|old| format!("{} was not counted", old.stage)));
        comparison
    }
}

/// The change as part of the value before.
fn change(before: f64, now: f64) -> f64 {
    if before > 0.0 {
        now / before - 1.0
    } else if now > 0.0 {
        f64::INFINITY
    } else {
        0.0
    }
}

pub(crate) fn millions(count: u64) -> f64 {
    count as f64 / 1e6
}

impl std::fmt::Display for Entry {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let error = self.error.zip(self.unit.as_deref()).map(|(error, unit)| format!("{error:.4} {unit}"));
        let (count, error) = (millions(self.instructions), error.unwrap_or_default());
        write!(f, "{:10} {count:9.2} M  {error:14}", self.stage)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(stage: Stage, instructions: u64, error: Option<f64>) -> Entry {
        let unit = error.map(|_| "px".to_owned());
        Entry { stage, instructions, first_cache_bytes: None, second_cache_bytes: None, error, unit }
    }

    fn record(stages: Vec<Entry>) -> Record {
        let word = || "any".to_owned();
        let (instruction_set, processor, rustc, valgrind) = (word(), word(), word(), word());
        Record { instruction_set, processor, rustc, valgrind, size: [640, 480], stages }
    }

    #[test]
    fn a_rise_beyond_the_limit_names_its_stage() {
        let record = record(vec![entry(Stage::Flow, 100_000_000, None), entry(Stage::Jpeg, 50_000_000, None)]);
        let within = record.compare(&[entry(Stage::Flow, 102_900_000, None), entry(Stage::Jpeg, 51_400_000, None)]);
        assert_eq!((within.faults.len(), within.lines.len()), (0, 2), "{within:?}");
        let beyond = record.compare(&[entry(Stage::Flow, 103_100_000, None), entry(Stage::Jpeg, 50_000_000, None)]);
        assert_eq!(
            beyond.faults,
            ["flow takes 103.10 M instructions a frame, 100.00 M before: 3.1 % more"],
            "{beyond:?}"
        );
    }

    #[test]
    fn an_error_that_is_no_number_does_not_pass() {
        let number = |error| Entry { unit: Some("px".to_owned()), ..entry(Stage::Flow, 100, error) };
        for (before, now) in [(Some(0.01), Some(f64::NAN)), (Some(0.01), None), (None, Some(0.01))] {
            let compared = record(vec![number(before)]).compare(&[number(now)]);
            assert_eq!(compared.faults, ["flow has no error in px to compare"], "{before:?}, {now:?}");
        }
    }

    #[test]
    fn fewer_instructions_pass_but_not_with_a_larger_error() {
        let record = record(vec![entry(Stage::Live, 100, Some(0.01))]);
        let better = record.compare(&[entry(Stage::Live, 90, Some(0.01))]);
        assert_eq!((better.faults.len(), better.fallen), (0, 1), "{better:?}");
        let worse = record.compare(&[entry(Stage::Live, 90, Some(0.0104))]);
        assert_eq!(worse.faults, ["live has an error of 0.01040 px, 0.01000 px before: 4.0 % more"]);
    }

    #[test]
    fn stages_that_only_one_side_has_are_faults() {
        let record = record(vec![entry(Stage::Flow, 100, None)]);
        let other = record.compare(&[entry(Stage::Exact, 100, None)]);
        assert_eq!(other.faults, ["exact is not in the record", "flow was not counted"]);
    }

    #[test]
    fn a_count_from_nothing_is_a_rise() {
        let record = record(vec![entry(Stage::Rest, 0, None)]);
        assert_eq!(record.compare(&[entry(Stage::Rest, 0, None)]).faults.len(), 0);
        assert_eq!(record.compare(&[entry(Stage::Rest, 1, None)]).faults.len(), 1);
    }

    #[test]
    fn a_record_survives_its_file() {
        let mut stage = entry(Stage::RestLive, 7, Some(0.25));
        stage.first_cache_bytes = Some(128);
        let record = record(vec![stage, entry(Stage::Reference, 9, None)]);
        let text = serde_json::to_string(&record).unwrap();
        assert!(text.contains("\"rest-live\""), "{text}");
        assert_eq!(serde_json::from_str::<Record>(&text).unwrap(), record);
    }
}

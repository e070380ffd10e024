//! The memory of a process over time.

use std::fs;

use anyhow::{Context, Result};

/// The memory of a process: seconds since the begin, and bytes.
#[derive(Debug, Default)]
pub(super) struct Memory {
    samples: Vec<(f64, u64)>,
}

/// The memory after warming up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Range {
    pub(super) least_bytes: u64,
    pub(super) most_bytes: u64,
}

impl Memory {
    pub(super) fn add(&mut self, time_s: f64, bytes: u64) {
        self.samples.push((time_s, bytes));
    }

    pub(super) fn last_bytes(&self) -> Option<u64> {
        self.samples.last().map(|(_, bytes)| *bytes)
    }

    /// Least and most from this time on; `None` without samples.
    pub(super) fn range(&self, from_s: f64) -> Option<Range> {
        let bytes = || self.samples.iter().filter(|(time_s, _)| *time_s >= from_s).map(|(_, bytes)| *bytes);
        Some(Range { least_bytes: bytes().min()?, most_bytes: bytes().max()? })
    }
}

impl Range {
    /// How much larger the most is than the least, as a part of the least.
    pub(super) fn spread(self) -> f64 {
        let (least, most) = (self.least_bytes as f64, self.most_bytes as f64);
        most / least - 1.0
    }
}

/// The resident memory of a process, bytes.
pub(super) fn resident_bytes(process: u32) -> Result<u64> {
    let path = format!("/proc/{process}/status");
    let status = fs::read_to_string(&path).with_context(|| format!("{path} cannot be read"))?;
    parse(&status).with_context(|| format!("{path} has no line VmRSS in kB"))
}

/// The value of the line `VmRSS:  361028 kB`.
fn parse(status: &str) -> Option<u64> {
    let value = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kilobytes: u64 = value.trim().strip_suffix("kB")?.trim_end().parse().ok()?;
    Some(1024 * kilobytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resident_memory_is_read_from_the_status_of_a_process() {
        assert_eq!(parse("VmPeak:\t  900 kB\nVmRSS:\t  361028 kB\nRssAnon:\t 5 kB\n"), Some(361_028 * 1024));
        assert_eq!(parse("VmRSS:\t 12 MB\n"), None);
        assert_eq!(parse("Name:\tdaemon\n"), None);
        assert!(resident_bytes(std::process::id()).unwrap() > 0);
    }

    #[test]
    fn memory_is_compared_after_warming_up() {
        let mut memory = Memory::default();
        for (time_s, bytes) in [(5.0, 100), (10.0, 190), (15.0, 200), (20.0, 209)] {
            memory.add(time_s, bytes);
        }
        assert_eq!(memory.last_bytes(), Some(209));
        let range = memory.range(10.0).unwrap();
        assert_eq!(range, Range { least_bytes: 190, most_bytes: 209 });
        assert!((range.spread() - 0.1).abs() < 1e-12, "{}", range.spread());
        assert_eq!(memory.range(20.5), None);
    }
}

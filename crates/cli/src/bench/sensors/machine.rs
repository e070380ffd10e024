//! Memory and processor time of this process. A value is absent if the system does not provide it.

use std::fs;

/// What the process has used so far.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Usage {
    /// Memory that it holds, bytes.
    pub(super) memory_bytes: Option<u64>,
    /// Processor time of all its threads, s.
    pub(super) cpu_s: Option<f64>,
    /// How often a thread had to make room for another one.
    pub(super) preemptions: Option<u64>,
}

impl Usage {
    /// Up to here.
    pub(super) fn now() -> Self {
        let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
        Self {
            memory_bytes: value(&status, "VmRSS:").map(|kibibytes| 1024 * kibibytes),
            cpu_s: cpu_s(),
            preemptions: preemptions(),
        }
    }

    /// Memory beyond that of an earlier moment, MiB.
    pub(super) fn more_mib(&self, before: &Self) -> Option<f64> {
        let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
        Some((mib(self.memory_bytes?) - mib(before.memory_bytes?)).max(0.0))
    }
}

/// The number behind a name in a file of the system.
fn value(text: &str, name: &str) -> Option<u64> {
    text.lines().find_map(|line| line.strip_prefix(name))?.split_whitespace().next()?.parse().ok()
}

/// Nanoseconds on a processor are the first number of a thread's `schedstat`.
fn cpu_s() -> Option<f64> {
    let times = fs::read_dir("/proc/self/task").ok()?.flatten().filter_map(|thread| {
        let text = fs::read_to_string(thread.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<u64>().ok()
    });
    Some(1e-9 * times.sum::<u64>() as f64)
}

fn preemptions() -> Option<u64> {
    let counts = fs::read_dir("/proc/self/task").ok()?.flatten().filter_map(|thread| {
        value(&fs::read_to_string(thread.path().join("status")).ok()?, "nonvoluntary_ctxt_switches:")
    });
    Some(counts.sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_found_behind_their_names() {
        let text = "VmPeak:\t  1000 kB\nVmRSS:\t  512 kB\n";
        assert_eq!(value(text, "VmRSS:"), Some(512));
        assert_eq!(value(text, "VmSwap:"), None);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn memory_and_time_of_this_process_are_known() {
        let usage = Usage::now();
        assert!(usage.memory_bytes.unwrap() > 100_000, "{usage:?}");
        let filled = vec![1_u8; 64 << 20];
        let after = Usage::now();
        assert!(after.more_mib(&usage).unwrap() > 30.0, "{usage:?}, {after:?}, {}", filled[filled.len() / 2]);
        assert!(after.cpu_s.unwrap() > 0.0);
    }
}

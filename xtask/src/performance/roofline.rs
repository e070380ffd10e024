//! The least time of a stage, and the machine's limits that it follows from.
//!
//! Two loops measure the limits. In a chain of operations of which each waits for the one before, an operation takes
//! one clock cycle, which shows the clock. Copying a block that fits no cache shows the bandwidth of the memory.

use std::hint::black_box;
use std::time::Instant;

/// Operations that a core of Zen 3 dispatches in a clock cycle; others dispatch 4 to 8.
const PER_CYCLE: f64 = 6.0;
/// Bytes that come from or go to the second cache in a clock cycle.
const CACHE_BYTES_PER_CYCLE: f64 = 32.0;
/// Rounds of the chain, and its operations in a round.
const ROUNDS: u64 = 10_000_000;
const CHAIN: u64 = 16;
const BLOCK_BYTES: usize = 64 << 20;
/// The fastest of so many runs counts, because other programs only slow them down.
const RUNS: usize = 7;

/// What the machine can do at most.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// Clock cycles per second.
    pub(super) clock_hz: f64,
    /// Bytes per second that are read or written.
    pub(super) memory_bytes_per_s: f64,
}

impl Limits {
    pub(super) fn measure() -> Self {
        let source = vec![1_u8; BLOCK_BYTES];
        let mut target = vec![0_u8; BLOCK_BYTES];
        let chain_s = fastest(|| {
            let (mut sum, step) = (black_box(1_u64), black_box(3_u64));
            for _ in 0..ROUNDS {
                for _ in 0..CHAIN / 2 {
                    // No compiler combines additions and exclusive ors.
                    sum = sum.wrapping_add(step) ^ step;
                }
            }
            black_box(sum);
        });
        let copy_s = fastest(|| {
            target.copy_from_slice(black_box(&source));
            black_box(&mut target);
        });
        let (operations, bytes) = ((ROUNDS * CHAIN) as f64, 2.0 * BLOCK_BYTES as f64);
        Self { clock_hz: operations / chain_s, memory_bytes_per_s: bytes / copy_s }
    }

    /// The least time of so many instructions, bytes between the caches, and bytes behind the second cache, ms: the largest
    /// of three times, because the three overlap.
    pub(super) fn least_ms(&self, instructions: u64, first_cache_bytes: u64, second_cache_bytes: u64) -> f64 {
        let cycles = (instructions as f64 / PER_CYCLE).max(first_cache_bytes as f64 / CACHE_BYTES_PER_CYCLE);
        1e3 * (cycles / self.clock_hz).max(second_cache_bytes as f64 / self.memory_bytes_per_s)
    }
}

fn fastest(mut work: impl FnMut()) -> f64 {
    let times = (0..RUNS).map(|_| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    });
    times.fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slowest_of_the_three_is_the_limit() {
        let limits = Limits { clock_hz: 2e9, memory_bytes_per_s: 1e10 };
        for (counts, expected_ms) in [
            ((120_000_000, 64_000_000, 50_000_000), 10.0),
            ((8_000_000, 640_000_000, 50_000_000), 10.0),
            ((8_000_000, 64_000_000, 50_000_000), 5.0),
        ] {
            let least_ms = limits.least_ms(counts.0, counts.1, counts.2);
            assert!((least_ms - expected_ms).abs() < 1e-12, "{counts:?}: {least_ms} ms");
        }
    }
}

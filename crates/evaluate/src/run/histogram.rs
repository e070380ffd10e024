//! Quantiles of more numbers than fit into memory.

/// Lower bits of a number that are ignored.
const DROPPED_BITS: u32 = 12;

/// A histogram of non-negative numbers by their leading bits.
///
/// The bit patterns of positive floats have the order of the numbers, so bins of equal leading bits have a width
/// proportional to their numbers: a quantile is exact to one part in 4096. The histogram takes 4 MB.
#[derive(Debug)]
pub(super) struct Histogram {
    counts: Vec<u64>,
    total: u64,
}

impl Histogram {
    pub(super) fn new() -> Self {
        Self { counts: vec![0; 1 << (31 - DROPPED_BITS)], total: 0 }
    }

    /// Counts a number, zero or above.
    pub(super) fn push(&mut self, value: f32) {
        self.counts[(value.abs().to_bits() >> DROPPED_BITS) as usize] += 1;
        self.total += 1;
    }

    /// The quantile of all numbers, `quantile` from 0 to 1; none if there are none.
    pub(super) fn quantile(&self, quantile: f64) -> Option<f64> {
        let mut left = rank(self.total, quantile)?;
        let bin = self.counts.iter().position(|&count| {
            let is_here = left < count;
            left = left.saturating_sub(count);
            is_here
        })?;
        let end = |bin: usize| f64::from(f32::from_bits((bin as u32) << DROPPED_BITS));
        // Zero has a bin of its own kind: its numbers are smaller than any error.
        Some(if bin == 0 { 0.0 } else { 0.5 * (end(bin) + end(bin + 1)) })
    }
}

/// The quantile of some numbers, `quantile` from 0 to 1; none if there are none. Changes the order of the numbers.
pub(super) fn quantile(values: &mut [f32], quantile: f64) -> Option<f64> {
    let rank = rank(values.len() as u64, quantile)?;
    Some(f64::from(*values.select_nth_unstable_by(rank as usize, f32::total_cmp).1))
}

/// The index of a quantile among sorted numbers, from 0: the nearest one.
fn rank(count: u64, quantile: f64) -> Option<u64> {
    let last = count.checked_sub(1)?;
    Some((quantile.clamp(0.0, 1.0) * last as f64).round() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantile_is_as_exact_as_documented() {
        let mut values: Vec<f32> = (0..10_000).map(|i| 1e-4 * 1.001_f32.powi(i * 7919 % 10_000)).collect();
        let mut histogram = Histogram::new();
        for &value in &values {
            histogram.push(value);
        }
        for part in [0.0, 0.05, 0.5, 0.95, 1.0] {
            let (counted, exact) = (histogram.quantile(part).unwrap(), quantile(&mut values, part).unwrap());
            assert!((counted / exact - 1.0).abs() < 1.0 / 4096.0, "{part}: {counted} instead of {exact}");
        }
    }

    #[test]
    fn zeros_and_nothing() {
        let mut histogram = Histogram::new();
        assert_eq!((histogram.quantile(0.5), quantile(&mut [], 0.5)), (None, None));
        histogram.push(0.0);
        histogram.push(-0.0);
        assert_eq!(histogram.quantile(0.95), Some(0.0));
    }

    #[test]
    fn the_largest_number_has_a_bin() {
        let mut histogram = Histogram::new();
        histogram.push(f32::MAX);
        assert!(histogram.quantile(1.0).is_some());
    }
}

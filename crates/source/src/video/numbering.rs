//! Sequence numbers by times: they show where frames are missing.

/// A gap between two frames is a missing frame if it is longer than this many usual intervals, dimensionless.
const LONGEST_INTERVAL: f64 = 1.5;

/// Largest number of missing frames in a gap: a damaged time must not make numbers overflow.
const MOST_MISSING: f64 = 1e9;

/// Sequence numbers by times in ascending order, s: from 0, with a gap where times jump.
///
/// An interval that is longer than 1.5 times the usual one, the median, counts as the number of usual intervals that
/// fit into it.
pub(crate) fn by_times(times_s: &[f64]) -> Vec<u64> {
    let mut intervals: Vec<f64> = times_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let steps = intervals.clone();
    intervals.sort_by(f64::total_cmp);
    let usual = intervals.get(intervals.len() / 2).copied().unwrap_or(0.0);
    let numbers = steps.iter().scan(0, |number, &interval| {
        let is_gap = usual > 0.0 && interval > LONGEST_INTERVAL * usual;
        *number += if is_gap { (interval / usual).round().min(MOST_MISSING) as u64 } else { 1 };
        Some(*number)
    });
    std::iter::once(0).chain(numbers).take(times_s.len()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_in_time_leaves_a_gap() {
        assert_eq!(by_times(&[0.0, 0.1, 0.2, 0.5, 0.6]), [0, 1, 2, 5, 6]);
        assert_eq!(by_times(&[0.0, 0.1, 0.21, 0.29, 0.43]), [0, 1, 2, 3, 4]);
        assert_eq!((by_times(&[3.0]), by_times(&[])), (vec![0], vec![]));
        assert_eq!(by_times(&[1.0, 1.0, 1.0]), [0, 1, 2]);
        assert_eq!(by_times(&[0.0, 1.0, 2.0, f64::INFINITY]), [0, 1, 2, 1_000_000_002]);
    }
}

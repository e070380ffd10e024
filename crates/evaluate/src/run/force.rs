//! Errors of the force.

use super::report::mean_of;
use super::table_file::Forces;
use super::{ForceErrors, ForceReport};

/// The largest true force of so many frames, N.
pub(super) fn peak_n(truth: &Forces, frames: u64) -> f64 {
    let length = |force: &[Option<f64>; 3]| force.iter().flatten().map(|value| value * value).sum::<f64>().sqrt();
    truth.iter().take(frames as usize).map(length).fold(0.0, f64::max)
}

/// The errors of one frame.
pub(super) fn frame_errors(estimated_n: [Option<f64>; 3], true_n: [Option<f64>; 3], peak_n: f64) -> ForceErrors {
    let error_n = [0, 1, 2].map(|axis| Some(estimated_n[axis]? - true_n[axis]?));
    ForceErrors { true_n, estimated_n, error_n, of_peak: error_n.map(|error| over(error, peak_n)) }
}

/// What the frames' errors come to.
pub(super) fn report(frames: &[ForceErrors], true_peak_n: f64) -> ForceReport {
    let sizes = [0, 1, 2]
        .map(|axis: usize| frames.iter().filter_map(|frame| frame.error_n[axis]).map(f64::abs).collect::<Vec<_>>());
    let mean_n = [0, 1, 2].map(|axis: usize| mean_of(&sizes[axis]));
    let largest_n = [0, 1, 2].map(|axis: usize| sizes[axis].iter().copied().reduce(f64::max));
    ForceReport { true_peak_n, mean_n, largest_n, mean_of_peak: mean_n.map(|mean| over(mean, true_peak_n)) }
}

/// A part of the largest force; none where there was none.
fn over(value: Option<f64>, peak_n: f64) -> Option<f64> {
    value.filter(|_| peak_n > 0.0).map(|value| value / peak_n)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_told_by_component_and_against_the_peak() {
        let truth = vec![[Some(0.0); 3], [Some(3.0), Some(0.0), Some(4.0)], [Some(30.0); 3]];
        let peak = peak_n(&truth, 2);
        assert!((peak - 5.0).abs() < 1e-12, "{peak} N: the third frame is not compared");
        let first = frame_errors([Some(1.0), None, Some(-1.0)], truth[0], peak);
        let second = frame_errors([Some(3.5), None, Some(2.0)], truth[1], peak);
        assert_eq!(first.error_n, [Some(1.0), None, Some(-1.0)]);
        assert_eq!(second.of_peak, [Some(0.1), None, Some(-0.4)]);
        let report = report(&[first, second], peak);
        assert_eq!(report.mean_n, [Some(0.75), None, Some(1.5)]);
        assert_eq!(report.largest_n, [Some(1.0), None, Some(2.0)]);
        assert_eq!(report.mean_of_peak, [Some(0.15), None, Some(0.3)]);
    }

    #[test]
    fn there_is_no_part_of_no_force() {
        let errors = frame_errors([Some(1.0); 3], [Some(0.0); 3], 0.0);
        assert_eq!(errors.of_peak, [None; 3]);
        assert_eq!(report(&[], 0.0).largest_n, [None; 3]);
    }
}

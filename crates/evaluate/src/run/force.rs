//! Errors of the force.

use super::report::mean_of;
use super::table_file::Forces;
use super::{ForceErrors, ForceReport, LoadErrors};

/// A shear force below this part of the normal force has no relative error.
pub(crate) const LEAST_SHEAR: f64 = 0.05;
/// A torque below the normal force times an arm of this length, mm, has no relative error.
pub(crate) const LEAST_ARM_MM: f64 = 0.1;

/// The largest true force of the frames, N.
pub(super) fn peak_n(truth: &Forces, frames: u64) -> f64 {
    let length = |force: &[Option<f64>; 4]| force[..3].iter().flatten().map(|value| value * value).sum::<f64>().sqrt();
    truth.iter().take(frames as usize).map(length).fold(0.0, f64::max)
}

/// The errors of one frame, of force and torque.
pub(super) fn frame_errors(estimated: [Option<f64>; 4], truth: [Option<f64>; 4], peak_n: f64) -> ForceErrors {
    let ([x, y, z, estimated_torque_nmm], [true_x, true_y, true_z, true_torque_nmm]) = (estimated, truth);
    let (estimated_n, true_n) = ([x, y, z], [true_x, true_y, true_z]);
    let error_n = [0, 1, 2].map(|axis| Some(estimated_n[axis]? - true_n[axis]?));
    let of_peak = error_n.map(|error| over(error, peak_n));
    ForceErrors { true_n, estimated_n, error_n, of_peak, true_torque_nmm, estimated_torque_nmm }
}

/// The summary of the frames' errors.
pub(super) fn report(frames: &[ForceErrors], true_peak_n: f64) -> ForceReport {
    let sizes = [0, 1, 2]
        .map(|axis: usize| frames.iter().filter_map(|frame| frame.error_n[axis]).map(f64::abs).collect::<Vec<_>>());
    let mean_n = [0, 1, 2].map(|axis: usize| mean_of(&sizes[axis]));
    let largest_n = [0, 1, 2].map(|axis: usize| sizes[axis].iter().copied().reduce(f64::max));
    let normal = |frame: &ForceErrors| Some([frame.true_n[2]?.abs(), frame.error_n[2]?.abs()]);
    let shear = |frame: &ForceErrors| {
        Some([frame.true_n[0]?.hypot(frame.true_n[1]?), frame.error_n[0]?.hypot(frame.error_n[1]?)])
    };
    let torque = |frame: &ForceErrors| {
        let truth = frame.true_torque_nmm?;
        Some([truth.abs(), (frame.estimated_torque_nmm? - truth).abs()])
    };
    ForceReport {
        true_peak_n,
        mean_n,
        largest_n,
        mean_of_peak: mean_n.map(|mean| over(mean, true_peak_n)),
        normal: load_errors(frames.iter().filter_map(normal), 0.0),
        shear: load_errors(frames.iter().filter_map(shear), LEAST_SHEAR * true_peak_n),
        torque: load_errors(frames.iter().filter_map(torque), LEAST_ARM_MM * true_peak_n),
    }
}

/// The errors of one part of the load, from its true size and its error in every frame; none without a frame. Without a
/// true peak above `least` there are no relative errors.
fn load_errors(frames: impl Iterator<Item = [f64; 2]>, least: f64) -> Option<LoadErrors> {
    let frames: Vec<[f64; 2]> = frames.collect();
    let [true_peak, error_at_peak] = frames.iter().copied().max_by(|a, b| a[0].total_cmp(&b[0]))?;
    let errors: Vec<f64> = frames.iter().map(|frame| frame[1]).collect();
    let mean = mean_of(&errors)?;
    let of_peak = |error: f64| (true_peak > least).then(|| error / true_peak);
    Some(LoadErrors {
        true_peak,
        mean,
        largest: errors.iter().copied().fold(0.0, f64::max),
        mean_of_peak: of_peak(mean),
        at_peak: of_peak(error_at_peak),
    })
}

/// An error relative to the largest force; none if that is 0.
fn over(value: Option<f64>, peak_n: f64) -> Option<f64> {
    value.filter(|_| peak_n > 0.0).map(|value| value / peak_n)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_reported_by_component_and_relative_to_the_peak() {
        let truth = vec![[Some(0.0); 4], [Some(3.0), Some(0.0), Some(4.0), Some(-2.0)], [Some(30.0); 4]];
        let peak = peak_n(&truth, 2);
        assert!((peak - 5.0).abs() < 1e-12, "{peak} N: the third frame is not compared");
        let first = frame_errors([Some(1.0), None, Some(-1.0), Some(0.0)], truth[0], peak);
        let second = frame_errors([Some(3.5), None, Some(2.0), Some(-1.5)], truth[1], peak);
        assert_eq!(first.error_n, [Some(1.0), None, Some(-1.0)]);
        assert_eq!(second.of_peak, [Some(0.1), None, Some(-0.4)]);
        let report = report(&[first, second], peak);
        assert_eq!(report.mean_n, [Some(0.75), None, Some(1.5)]);
        assert_eq!(report.largest_n, [Some(1.0), None, Some(2.0)]);
        assert_eq!(report.mean_of_peak, [Some(0.15), None, Some(0.3)]);
        let normal = report.normal.unwrap();
        assert_eq!((normal.true_peak, normal.mean, normal.largest, normal.at_peak), (4.0, 1.5, 2.0, Some(0.5)));
        let torque = report.torque.unwrap();
        assert_eq!((torque.true_peak, torque.at_peak, torque.mean_of_peak), (2.0, Some(0.25), Some(0.125)));
        assert_eq!(report.shear, None, "no frame has both of its components");
        let small = load_errors([[0.2, 0.1], [0.1, 0.3]].into_iter(), 0.25).unwrap();
        assert_eq!((small.true_peak, small.mean, small.at_peak, small.mean_of_peak), (0.2, 0.2, None, None));
    }

    #[test]
    fn there_is_no_part_of_no_force() {
        let errors = frame_errors([Some(1.0); 4], [Some(0.0); 4], 0.0);
        assert_eq!(errors.of_peak, [None; 3]);
        assert_eq!(report(&[], 0.0).largest_n, [None; 3]);
        assert_eq!(report(&[errors], 0.0).normal.unwrap().at_peak, None);
    }
}

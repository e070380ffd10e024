//! Whether the images of a press are in the order of its depths: the gel moves more the deeper it is pressed.

use fingervision_touch::Reading;

/// Correlation of motion and depth that a press has at least, dimensionless.
pub(crate) const LEAST_CORRELATION: f64 = 0.7;
/// Fewer frames show no order.
const LEAST_COUNTED: usize = 4;
/// Every this many pixels the motion is read along both axes.
const STEP: usize = 4;

/// The largest valid motion of a reading, px.
pub(crate) fn largest_motion_px(reading: &Reading) -> f64 {
    let flow = &reading.flow;
    let mut largest = 0.0_f32;
    for (y, valid) in reading.valid.rows().enumerate().step_by(STEP) {
        let rows = flow.u.row(y).iter().zip(flow.v.row(y)).zip(valid);
        for ((u, v), _) in rows.step_by(STEP).filter(|(_, valid)| **valid == 1) {
            largest = largest.max(u.hypot(*v));
        }
    }
    largest.into()
}

/// Correlation of the two columns, depth and motion; none where there are too few rows or a column does not change.
pub(crate) fn correlation(rows: &[[f64; 2]]) -> Option<f64> {
    let count = rows.len() as f64;
    let mean = [0, 1].map(|column| rows.iter().map(|row| row[column]).sum::<f64>() / count);
    let sum = |a: usize, b: usize| rows.iter().map(|row| (row[a] - mean[a]) * (row[b] - mean[b])).sum::<f64>();
    let scale = (sum(0, 0) * sum(1, 1)).sqrt();
    (rows.len() >= LEAST_COUNTED && scale > 0.0).then(|| sum(0, 1) / scale)
}

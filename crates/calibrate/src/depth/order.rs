//! Checks whether the images of a press are in the order of its depths: the deeper the press, the larger the motion.

use fingervision_touch::Reading;

use super::regression::fit_line;
use super::thresholds::THRESHOLDS;

/// Least correlation of motion and depth in a press, dimensionless.
pub(crate) const LEAST_CORRELATION: f64 = THRESHOLDS.least_correlation;

/// Distance between the pixels whose motion is read, along both axes.
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

/// The correlation of depth, mm, and largest motion, px, over a press's frames if it is so small that the images are
/// not in order; none if there are too few frames, or if depth or motion does not change.
pub(crate) fn disorder(motions: &[[f64; 2]]) -> Option<f64> {
    let line = fit_line(motions).filter(|line| line.count >= THRESHOLDS.least_counted)?;
    (line.correlation < LEAST_CORRELATION).then_some(line.correlation)
}

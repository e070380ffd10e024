//! Detects whether the gel is at rest, and measures the drift of the untouched gel.
//!
//! The gel is at rest as long as its flow is close to a stored flow, that of the untouched gel, which is zero at first.
//! Once the gel has been at rest for some time, the stored flow is replaced by the current one. In this way the stored
//! flow follows slow changes, but not a touch, which is faster. After a touch the gel is at rest again when its flow
//! has returned to the stored one. A large stored flow means that the reference has drifted; a residual that has grown
//! at rest means that it has aged.
//!
//! A press that grows as slowly as such a change counts as drift.

use fingervision_flow::Estimate;

use super::flow_at;
use super::thresholds::THRESHOLDS;

/// Distance between samples along both axes, px.
const STEP: usize = 16;

/// The untouched gel.
#[derive(Debug)]
pub(super) struct Rest {
    /// Columns and rows of the image, px.
    size: (usize, usize),
    /// Flow of the untouched gel at the samples, row by row, px.
    untouched: Vec<[f32; 2]>,
    /// Start of the current interval at rest, after which the stored flow is replaced, s.
    slow_since_s: Option<f64>,
    /// Sum and number of the residuals in this interval.
    residuals: (f32, f32),
    /// Mean residual of the first such interval, grey levels.
    first_residual: Option<f32>,
    has_moved: bool,
    has_aged: bool,
    /// Time since which the gel has been at rest, s.
    since_s: Option<f64>,
}

impl Rest {
    /// For images of this size, px.
    pub(super) fn new(size: (usize, usize)) -> Self {
        Self {
            size,
            untouched: vec![[0.0; 2]; places(size).count()],
            slow_since_s: None,
            residuals: (0.0, 0.0),
            first_residual: None,
            has_moved: false,
            has_aged: false,
            since_s: None,
        }
    }

    /// Begins again with a new reference.
    pub(super) fn restart(&mut self) {
        self.untouched.fill([0.0; 2]);
        (self.slow_since_s, self.since_s, self.first_residual) = (None, None, None);
        (self.has_moved, self.has_aged) = (false, false);
    }

    /// Whether the reference has drifted or aged.
    pub(super) fn is_drifted(&self) -> bool {
        self.has_moved || self.has_aged
    }

    /// Time since which the gel has been at rest, s of the frames' clock.
    pub(super) fn since_s(&self) -> Option<f64> {
        self.since_s
    }

    /// Ends the rest, because something touches the gel, whatever its flow.
    pub(super) fn disturb(&mut self) {
        (self.slow_since_s, self.since_s) = (None, None);
    }

    /// Takes a frame; returns whether the gel is at rest.
    pub(super) fn watch(&mut self, time_s: f64, estimate: &Estimate, is_lost: bool) -> bool {
        let off_px = if is_lost { f32::INFINITY } else { self.off_px(estimate) };
        if off_px.is_nan() || off_px >= THRESHOLDS.rest_px || !time_s.is_finite() {
            self.disturb();
            return false;
        }
        self.since_s.get_or_insert(time_s);
        if off_px < THRESHOLDS.slow_px {
            self.follow(time_s, estimate);
        } else {
            self.slow_since_s = None;
        }
        true
    }

    /// Replaces the flow of the untouched gel at the end of an interval.
    fn follow(&mut self, time_s: f64, estimate: &Estimate) {
        let Some(since_s) = self.slow_since_s else {
            (self.slow_since_s, self.residuals) = (Some(time_s), (0.0, 0.0));
            return;
        };
        // The reference itself has no residual, nor has its repetition in a sequence that is played again.
        if estimate.residual_levels > THRESHOLDS.repeated_levels {
            self.residuals.0 += estimate.residual_levels;
            self.residuals.1 += 1.0;
        }
        if time_s - since_s < THRESHOLDS.slow_s {
            return;
        }
        self.slow_since_s = None;
        for (place, untouched) in places(self.size).zip(&mut self.untouched) {
            if let Some(flow) = flow_at(estimate, place) {
                *untouched = flow;
            }
        }
        let squares = self.untouched.iter().map(|[u, v]| u * u + v * v).sum::<f32>();
        let drift_px = (squares / self.untouched.len().max(1) as f32).sqrt();
        let (sum, count) = self.residuals;
        self.has_moved = drift_px > THRESHOLDS.drift_px;
        if count > 0.0 {
            let residual = sum / count;
            let first = *self.first_residual.get_or_insert(residual);
            self.has_aged = residual > THRESHOLDS.aged * first;
        }
    }

    /// Difference between the flow and that of the untouched gel where both are valid, px (root mean square); NaN where
    /// nothing is valid.
    fn off_px(&self, estimate: &Estimate) -> f32 {
        let (mut squares, mut count) = (0.0_f32, 0.0_f32);
        for (place, [u, v]) in places(self.size).zip(&self.untouched) {
            if let Some([now_u, now_v]) = flow_at(estimate, place) {
                squares += (now_u - u).powi(2) + (now_v - v).powi(2);
                count += 1.0;
            }
        }
        (squares / count).sqrt()
    }
}

/// The samples, row by row, px.
fn places((width, height): (usize, usize)) -> impl Iterator<Item = (usize, usize)> {
    let along = |length: usize| (STEP / 2..length).step_by(STEP);
    along(height).flat_map(move |y| along(width).map(move |x| (x, y)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (usize, usize) = (64, 48);

    /// Whether the reference has aged after frames at rest, two a second, with these residuals.
    fn has_aged(residuals: &[f32]) -> bool {
        let mut rest = Rest::new(SIZE);
        let mut estimate = Estimate::new(SIZE.0, SIZE.1);
        estimate.valid.values_mut().fill(1);
        for (frame, residual) in residuals.iter().enumerate() {
            estimate.residual_levels = *residual;
            assert!(rest.watch(0.5 * frame as f64, &estimate, false));
        }
        rest.is_drifted()
    }

    #[test]
    fn a_residual_that_grows_is_ageing() {
        assert!(!has_aged(&[[0.0].as_slice(), &[2.0; 40]].concat()));
        assert!(has_aged(&[[0.0].as_slice(), &[2.0; 20], &[3.5; 20]].concat()));
        assert!(has_aged(&[[0.0].as_slice(), &[2.0; 20], &[3.5; 20], &[0.0; 8]].concat()), "the reference again");
    }

    #[test]
    fn a_reference_that_is_repeated_is_not_ageing() {
        assert!(!has_aged(&[[0.0; 8].as_slice(), &[2.0; 20]].concat()), "nothing but the reference at first");
        assert!(
            !has_aged(&[[0.0, 0.01, 0.0, 2.0, 0.0].as_slice(), &[2.0; 20]].concat()),
            "mostly the reference at first"
        );
    }
}

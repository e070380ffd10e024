//! Detects whether the gel is at rest, and measures the drift of the untouched gel.
//!
//! The gel is at rest as long as its flow is close to a stored flow, that of the untouched gel, which is zero at first.
//! Once the gel has been at rest for some time, the stored flow is replaced by the current one. In this way the stored
//! flow follows slow changes, but not a touch, which is faster. After a touch the gel is at rest again when its flow
//! has returned to the stored one. A large stored flow means that the reference has drifted; a residual that has grown
//! at rest means that it has aged.
//!
//! A bump of the camera moves the whole image at once and for good: a shift, a rotation and a magnification explain nearly all of
//! the flow, which no press does. If such a flow stays as it is for some time and nothing touches the gel, it is that of the untouched
//! gel, and the reference has drifted.
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
    /// The flow of an image that has moved as a whole, since `moved_since_s`.
    moved: Vec<[f32; 2]>,
    moved_since_s: Option<f64>,
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
            moved: vec![[0.0; 2]; places(size).count()],
            moved_since_s: None,
        }
    }

    /// Begins again with a new reference.
    pub(super) fn restart(&mut self) {
        self.untouched.fill([0.0; 2]);
        self.disturb();
        self.first_residual = None;
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
        (self.slow_since_s, self.since_s, self.moved_since_s) = (None, None, None);
    }

    /// Takes a frame; returns whether the gel is at rest.
    pub(super) fn watch(&mut self, time_s: f64, estimate: &Estimate, is_lost: bool) -> bool {
        if is_lost || !time_s.is_finite() {
            self.disturb();
            return false;
        }
        let off_px = off_px(self.size, estimate, &self.untouched);
        if off_px.is_nan() || off_px >= THRESHOLDS.rest_px {
            (self.slow_since_s, self.since_s) = (None, None);
            return self.has_moved_as_a_whole(time_s, estimate);
        }
        self.moved_since_s = None;
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
        self.take_untouched(estimate);
        let (sum, count) = self.residuals;
        if count > 0.0 {
            let residual = sum / count;
            let first = *self.first_residual.get_or_insert(residual);
            self.has_aged = residual > THRESHOLDS.aged * first;
        }
    }

    /// Takes a flow for that of the untouched gel.
    fn take_untouched(&mut self, estimate: &Estimate) {
        store(self.size, estimate, &mut self.untouched);
        let squares = self.untouched.iter().map(|[u, v]| u * u + v * v).sum::<f32>();
        let drift_px = (squares / self.untouched.len().max(1) as f32).sqrt();
        self.has_moved = drift_px > THRESHOLDS.drift_px;
    }

    /// Whether the whole image has moved, and has stayed there long enough to be that of the untouched gel; its flow is then stored.
    fn has_moved_as_a_whole(&mut self, time_s: f64, estimate: &Estimate) -> bool {
        let stays = |_: &f64| off_px(self.size, estimate, &self.moved) < THRESHOLDS.slow_px;
        let Some(since_s) = self.moved_since_s.filter(stays) else {
            self.moved_since_s = moves_as_a_whole(self.size, estimate).then_some(time_s);
            store(self.size, estimate, &mut self.moved);
            return false;
        };
        if time_s - since_s < THRESHOLDS.slow_s {
            return false;
        }
        self.take_untouched(estimate);
        (self.since_s, self.moved_since_s) = (Some(since_s), None);
        true
    }
}

/// Stores the flow at the samples, where it is valid.
fn store(size: (usize, usize), estimate: &Estimate, flows: &mut [[f32; 2]]) {
    for (place, stored) in places(size).zip(flows) {
        if let Some(flow) = flow_at(estimate, place) {
            *stored = flow;
        }
    }
}

/// Difference between the flow and a stored one where it is valid, px (root mean square); NaN where nothing is valid.
fn off_px(size: (usize, usize), estimate: &Estimate, stored: &[[f32; 2]]) -> f32 {
    let (mut squares, mut count) = (0.0_f32, 0.0_f32);
    for (place, [u, v]) in places(size).zip(stored) {
        if let Some([now_u, now_v]) = flow_at(estimate, place) {
            squares += (now_u - u).powi(2) + (now_v - v).powi(2);
            count += 1.0;
        }
    }
    (squares / count).sqrt()
}

/// Whether a shift, a rotation and a magnification explain nearly all of the flow, and the image shows enough of it: the least-squares
/// fit leaves little of its square.
fn moves_as_a_whole(size: (usize, usize), estimate: &Estimate) -> bool {
    let middle = [size.0, size.1].map(|length| 0.5 * length as f32);
    // Sums over the samples: 1, place, flow; squares of both; flow along and across the place.
    let (mut count, mut all) = (0.0_f32, 0.0_f32);
    let (mut place_sum, mut flow_sum) = ([0.0_f32; 2], [0.0_f32; 2]);
    let (mut place_squares, mut flow_squares, mut along, mut across) = (0.0_f32, 0.0_f32, 0.0_f32, 0.0_f32);
    for place in places(size) {
        all += 1.0;
        let Some([u, v]) = flow_at(estimate, place) else { continue };
        let [x, y] = [place.0 as f32 - middle[0], place.1 as f32 - middle[1]];
        count += 1.0;
        place_sum = [place_sum[0] + x, place_sum[1] + y];
        flow_sum = [flow_sum[0] + u, flow_sum[1] + v];
        place_squares += x * x + y * y;
        flow_squares += u * u + v * v;
        along += x * u + y * v;
        across += x * v - y * u;
    }
    if count < THRESHOLDS.least_seen * all {
        return false;
    }
    let [[x, y], [u, v]] = [place_sum, flow_sum];
    let spread = place_squares - (x * x + y * y) / count;
    let along = along - (x * u + y * v) / count;
    let across = across - (x * v - y * u) / count;
    let explained = (u * u + v * v) / count + (along * along + across * across) / spread.max(1.0);
    flow_squares - explained <= THRESHOLDS.most_bent.powi(2) * flow_squares
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

    /// Whether the gel counts as untouched after frames that all show this flow, ten a second, and whether the reference has drifted.
    fn after_bump(seconds: f64, flow: impl Fn(f32, f32) -> [f32; 2], disturbed: bool) -> (bool, bool) {
        let mut rest = Rest::new(SIZE);
        let mut estimate = Estimate::new(SIZE.0, SIZE.1);
        estimate.valid.values_mut().fill(1);
        let mut is_untouched = rest.watch(0.0, &estimate, false);
        assert!(is_untouched);
        for y in 0..SIZE.1 {
            for x in 0..SIZE.0 {
                let [u, v] = flow(x as f32, y as f32);
                (estimate.flow.u.row_mut(y)[x], estimate.flow.v.row_mut(y)[x]) = (u, v);
            }
        }
        for frame in 1..=(10.0 * seconds) as usize {
            is_untouched = rest.watch(0.1 * frame as f64, &estimate, false);
            if disturbed {
                rest.disturb();
            }
        }
        (is_untouched, rest.is_drifted())
    }

    #[test]
    fn an_image_that_moved_as_a_whole_and_stays_is_untouched_and_drifted() {
        let shift = |_, _| [10.0, -3.0];
        let turn = |x: f32, y: f32| [1.0 + 0.02 * x - 0.05 * y, 0.05 * x + 0.02 * y];
        assert_eq!(after_bump(3.0, shift, false), (true, true));
        assert_eq!(after_bump(3.0, turn, false), (true, true));
        assert_eq!(after_bump(1.5, shift, false), (false, false), "too short");
        assert_eq!(after_bump(3.0, shift, true), (false, false), "something touches the gel");
    }

    #[test]
    fn a_press_that_stays_is_no_moved_image() {
        let press = |x: f32, y: f32| {
            let (dx, dy) = (x - 30.0, y - 20.0);
            let weight = 4.0 * (-(dx * dx + dy * dy) / 200.0).exp();
            [0.3 * weight * dx, 0.3 * weight * dy]
        };
        assert_eq!(after_bump(5.0, press, false), (false, false));
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

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
//!
//! The part of the stored flow that is a motion of the whole image is measured, too ([`UntouchedMotion`]).

use fingervision_flow::Estimate;

use super::flow_at;
use super::thresholds::THRESHOLDS;
use super::untouched_motion::UntouchedMotion;
use crate::whole_motion::{FittedMotion, WholeMotion};

/// Distance between samples along both axes, px.
const STEP: usize = 16;
/// Any flow of fewer samples may be that of a motion of the whole image, which has four numbers.
const LEAST_SAMPLES: f32 = 8.0;

/// The untouched gel.
#[derive(Debug)]
pub(super) struct Rest {
    /// Columns and rows of the image, px.
    size: (usize, usize),
    /// Flow of the untouched gel at the samples, row by row, px.
    untouched: Vec<[f32; 2]>,
    motion: UntouchedMotion,
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
            motion: UntouchedMotion::NONE,
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
        self.moved.fill([0.0; 2]);
        self.motion = UntouchedMotion::NONE;
        self.disturb();
        (self.residuals, self.first_residual) = ((0.0, 0.0), None);
        (self.has_moved, self.has_aged) = (false, false);
    }

    /// Whether the reference has drifted or aged.
    pub(super) fn is_drifted(&self) -> bool {
        self.has_moved || self.has_aged
    }

    /// The motion of the whole image since the reference on the untouched gel.
    pub(super) fn untouched_motion(&self) -> WholeMotion {
        self.motion.known()
    }

    /// Time since which the gel has been at rest, s of the frames' clock.
    pub(super) fn since_s(&self) -> Option<f64> {
        self.since_s
    }

    /// Ends the rest, because something touches the gel, whatever its flow.
    pub(super) fn disturb(&mut self) {
        (self.slow_since_s, self.since_s, self.moved_since_s) = (None, None, None);
        self.motion.disturb();
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
        self.since_s.get_or_insert(time_s);
        if off_px < THRESHOLDS.slow_px {
            self.moved_since_s = None;
            self.follow(time_s, estimate);
        } else {
            self.slow_since_s = None;
            self.has_moved_as_a_whole(time_s, estimate);
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
        self.motion.take(whole_motion(self.size, estimate, None));
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

    /// Whether the whole image has moved from where the gel was untouched, and has stayed there long enough to be that of the untouched gel;
    /// its flow is then stored.
    fn has_moved_as_a_whole(&mut self, time_s: f64, estimate: &Estimate) -> bool {
        let stays = |_: &f64| off_px(self.size, estimate, &self.moved) < THRESHOLDS.slow_px;
        let since_s = self.moved_since_s.filter(stays);
        if since_s.is_some_and(|since_s| time_s - since_s < THRESHOLDS.slow_s) {
            return false;
        }
        let step = whole_motion(self.size, estimate, Some(&self.untouched));
        let Some(since_s) = since_s else {
            let is_even = step.is_some_and(|step| step.left_px <= THRESHOLDS.most_bent * step.flow_px);
            self.moved_since_s = is_even.then_some(time_s);
            store(self.size, estimate, &mut self.moved);
            return false;
        };
        self.take_untouched(estimate);
        if step.is_some_and(|step| step.flow_px <= f64::from(THRESHOLDS.rest_px)) {
            self.motion.take(whole_motion(self.size, estimate, None));
        } else {
            self.motion.jump(self.has_moved);
        }
        (self.since_s, self.moved_since_s) = (self.since_s.or(Some(since_s)), None);
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

/// The shift, the rotation and the magnification that fit the flow best, or its difference from a stored one, if the image shows enough of
/// it.
fn whole_motion(size: (usize, usize), estimate: &Estimate, from: Option<&[[f32; 2]]>) -> Option<FittedMotion> {
    let flows = places(size).enumerate().filter_map(|(sample, place)| {
        let [u, v] = flow_at(estimate, place)?;
        let [from_u, from_v] = from.map_or([0.0; 2], |stored| stored[sample]);
        Some(([place.0 as f64, place.1 as f64], [f64::from(u - from_u), f64::from(v - from_v)]))
    });
    let least = (THRESHOLDS.least_seen * places(size).count() as f32).max(LEAST_SAMPLES);
    WholeMotion::fit(flows).filter(|fit| fit.count as f32 >= least)
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
    fn after_a_restart_nothing_is_left_of_the_frames_before() {
        let mut rest = Rest::new(SIZE);
        let mut estimate = Estimate::new(SIZE.0, SIZE.1);
        estimate.valid.values_mut().fill(1);
        estimate.residual_levels = 2.0;
        for frame in 0..200 {
            estimate.flow.u.values_mut().fill(if frame < 100 { 0.001 * frame as f32 } else { 7.0 });
            rest.watch(0.1 * f64::from(frame), &estimate, false);
        }
        assert!(rest.is_drifted());
        rest.restart();
        assert_eq!(format!("{rest:?}"), format!("{:?}", Rest::new(SIZE)));
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

    /// The displacement of the upper left corner of the image that is undone after ten frames a second with these flows; `touched` at the end of a frame.
    fn undone(frames: usize, flow: impl Fn(f32, f32, f32) -> [f32; 2], touched: impl Fn(f32) -> bool) -> [f64; 2] {
        let mut rest = Rest::new(SIZE);
        let mut estimate = Estimate::new(SIZE.0, SIZE.1);
        estimate.valid.values_mut().fill(1);
        for frame in 0..frames {
            let time_s = 0.1 * frame as f32;
            for y in 0..SIZE.1 {
                for x in 0..SIZE.0 {
                    let [u, v] = flow(x as f32 - 31.5, y as f32 - 23.5, time_s);
                    (estimate.flow.u.row_mut(y)[x], estimate.flow.v.row_mut(y)[x]) = (u, v);
                }
            }
            rest.watch(f64::from(time_s), &estimate, false);
            if touched(time_s) {
                rest.disturb();
            }
        }
        let corner = rest.untouched_motion().undo([0.0, 0.0]);
        corner.map(|px| -px)
    }

    #[test]
    fn a_slow_motion_of_the_whole_image_is_measured() {
        let slow = |x: f32, y: f32, time_s: f32| {
            let part = (time_s / 8.0).min(1.0);
            [part * (0.2 + 0.003 * x), part * (0.003 * y - 0.1)]
        };
        let [u, v] = undone(150, slow, |_| false);
        assert!((u - 0.1055).abs() < 2e-3 && (v + 0.1705).abs() < 2e-3, "{u} {v} px");
        let [u, v] = undone(150, slow, |time_s| time_s > 3.0);
        assert!(u.hypot(v) < 0.05, "what comes with a touch is not measured: {u} {v} px");
    }

    #[test]
    fn a_light_touch_that_is_held_is_not_taken_for_a_motion_of_the_whole_image() {
        let touch = |x: f32, y: f32, time_s: f32| {
            let part = 0.02 * (time_s / 4.0).min(1.0) * (-(x * x + y * y) / 200.0).exp();
            [part * x, part * y]
        };
        assert_eq!(undone(120, touch, |_| false).map(f64::to_bits), [-0.0_f64; 2].map(f64::to_bits));
    }

    #[test]
    fn a_jump_is_not_undone_and_forgotten_when_the_camera_is_back() {
        let jump = |_: f32, _: f32, time_s: f32| if (1.0..6.0).contains(&time_s) { [10.0, -4.0] } else { [0.0, 0.0] };
        for seconds in [5.5, 7.0, 20.0] {
            let [u, v] = undone((10.0 * seconds) as usize, jump, |_| false);
            assert!(u.abs() < 1e-6 && v.abs() < 1e-6, "{u} {v} px after {seconds} s");
        }
        let again = |x: f32, _: f32, time_s: f32| {
            if time_s < 8.0 { jump(x, 0.0, time_s) } else { [0.02 * (time_s - 8.0).min(8.0), 0.0] }
        };
        let [u, _] = undone(250, again, |_| false);
        assert!((u - 0.16).abs() < 0.01, "a slow motion after it is: {u} px");
    }
}

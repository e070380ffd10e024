//! Runs a tracker through a sequence and compares every reading with the truth.

use super::Script;
use crate::pairs::BORDER_PX;
use crate::{EvaluateError, end_point_errors, quantile, without_border};
use fingervision_flow::FlowField;
use fingervision_gel::Motion;
use fingervision_image::{Frame, Image};
use fingervision_touch::{Fields, Flag, Policy, Profile, Tracker};

/// An error beyond which a displacement counts as wrong, px.
const WRONG_PX: f32 = 1.0;

/// The errors of one reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameError {
    /// Mean end-point error, px.
    pub mean_px: f64,
    /// 99th percentile of the end-point error, px.
    pub high_px: f64,
    /// Part of all pixels that are valid but have an error of more than 1 px.
    pub trusted_wrong: f64,
    /// Whether the reading has the flag of a gel that was pressed at the start.
    pub is_pressed_at_start: bool,
}

/// The errors of the readings of a sequence.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// One entry per frame.
    pub frames: Vec<FrameError>,
}

impl Outcome {
    /// Mean over all frames but the first, px.
    #[must_use]
    pub fn mean_px(&self) -> f64 {
        let moved = &self.frames[1..];
        moved.iter().map(|frame| frame.mean_px).sum::<f64>() / moved.len() as f64
    }

    /// Mean error of the last frame, px.
    #[must_use]
    pub fn final_px(&self) -> f64 {
        self.frames.last().map_or(f64::NAN, |frame| frame.mean_px)
    }

    /// The largest of the frames' mean errors, px.
    #[must_use]
    pub fn largest_px(&self) -> f64 {
        self.frames.iter().map(|frame| frame.mean_px).fold(0.0, f64::max)
    }

    /// The largest of the frames' 99th percentiles, px.
    #[must_use]
    pub fn largest_high_px(&self) -> f64 {
        self.frames.iter().map(|frame| frame.high_px).fold(0.0, f64::max)
    }

    /// Largest part of a frame's pixels that are valid but have an error of more than 1 px.
    #[must_use]
    pub fn trusted_wrong(&self) -> f64 {
        self.frames.iter().map(|frame| frame.trusted_wrong).fold(0.0, f64::max)
    }
}

/// Tracks the frames of a script under a policy.
///
/// The truth is relative to the image that the tracker refers to: the first one, until a gel that was pressed at the
/// start has come to rest and the tracker takes a new reference. From then on the readings no longer have the flag of a
/// press at the start.
///
/// # Errors
///
/// [`EvaluateError::Track`] if a frame cannot be tracked.
pub fn follow(script: &Script, frames: &[Frame], policy: Policy) -> Result<Outcome, EvaluateError> {
    let mut profile = Profile::default();
    profile.references.policy = policy;
    let size = (script.sheet.width, script.sheet.height);
    let mut tracker = Tracker::new(&profile, size, true, Fields::NONE)?;
    let region = without_border(size, BORDER_PX);
    let mut reference = script.steps[0].motion;
    let mut was_pressed = false;
    let mut errors = Vec::with_capacity(frames.len());
    for (step, frame) in script.steps.iter().zip(frames) {
        let reading = tracker.track(frame)?;
        let is_pressed_at_start = reading.flags.has(Flag::PressedAtStart);
        let truth = flow_between(&reference, &step.motion, size);
        let found: Vec<f32> = end_point_errors(&reading.flow, &truth, region).collect();
        let wrong = end_point_errors(&reading.flow, &truth, region).zip(inside(&reading.valid, region));
        let trusted_wrong = wrong.filter(|&(error, valid)| error > WRONG_PX && valid == 1).count();
        errors.push(FrameError {
            mean_px: crate::mean(found.iter().copied()),
            trusted_wrong: trusted_wrong as f64 / found.len() as f64,
            high_px: quantile(found, 0.99),
            is_pressed_at_start,
        });
        if was_pressed && !is_pressed_at_start {
            reference = step.motion;
        }
        was_pressed = is_pressed_at_start;
    }
    Ok(Outcome { frames: errors })
}

fn inside(image: &Image<u8>, region: fingervision_image::Rect) -> impl Iterator<Item = u8> {
    let rows = region.y..region.y + region.height;
    rows.flat_map(move |y| image.row(y)[region.x..region.x + region.width].iter().copied())
}

/// The flow from one state of the gel to another, on the image grid of the first.
fn flow_between(from: &Motion, to: &Motion, (width, height): (usize, usize)) -> FlowField {
    let displacement = Image::from_fn(width, height, |x, y| {
        let (x, y) = (x as f64, y as f64);
        // The point of the resting gel that is seen here.
        let (rest_x, rest_y) = from.reference_point(x, y);
        let (u, v) = to.displacement(rest_x, rest_y);
        [(rest_x + u - x) as f32, (rest_y + v - y) as f32]
    });
    let plane = |axis: usize| Image::from_fn(width, height, |x, y| displacement.at(x, y)[axis]);
    FlowField { u: plane(0), v: plane(1) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back_compose() {
        let bump = Motion::radial_bump([31.5, 23.5], 6.0);
        let size = (64, 48);
        let there = flow_between(&Motion::STILL, &bump, size);
        let truth = bump.flow(64, 48);
        assert!(there.u.values().iter().zip(truth.u.values()).all(|(a, b)| (a - b).abs() < 1e-5));
        assert!(flow_between(&bump, &bump, size).v.values().iter().all(|v| v.abs() < 1e-5));
        let back = flow_between(&bump, &Motion::STILL, size);
        // The centre does not move, and everything else returns towards it.
        assert!(back.u.at(10, 23) > 0.0 && back.u.at(53, 23) < 0.0);
    }
}

//! The course of a sequence: motion and light of every frame.

use crate::EvaluateError;
use crate::pairs::TILTED_LIGHT;
use fingervision_gel::{Light, Motion, Sheet, SheetRenderer};
use fingervision_image::{Frame, Pixels};
use rayon::prelude::*;

/// Frames per second.
const RATE_HZ: f64 = 30.0;
/// Number of frames in which a gel pressed at the start returns to rest, and in which it is pressed again.
const RELEASE_FRAMES: usize = 10;
/// Number of frames at rest in between: more than the tracker waits for.
const RESTING_FRAMES: usize = 35;
/// Number of frames in which it stays pressed at first.
const HOLDING_FRAMES: usize = 3;
/// The frame at which a gel pressed at the start is released.
pub(super) const RELEASED: usize = HOLDING_FRAMES + RELEASE_FRAMES;

/// The content of one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// The frame's number; a gap is a dropped frame.
    pub sequence: u64,
    /// The motion of the gel's points.
    pub motion: Motion,
    /// The light.
    pub light: Light,
}

/// A sheet and its frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Script {
    /// The sheet.
    pub sheet: Sheet,
    /// The frames.
    pub steps: Vec<Step>,
}

impl Script {
    /// A round bump that grows evenly from zero to its amplitude in this many frames.
    #[must_use]
    pub fn press(amplitude_px: f64, frames: usize) -> Self {
        Self::bump(amplitude_px, (0..=frames).map(|frame| frame as f64 / frames as f64))
    }

    /// Presses and releases, one after another, each with this many frames for the press and for the release.
    #[must_use]
    pub fn presses(amplitude_px: f64, frames: usize, count: usize) -> Self {
        let fraction = move |frame: usize| 1.0 - (frame as f64 / frames as f64 - 1.0).abs();
        let cycles = (0..count).flat_map(|_| 1..=2 * frames).map(fraction);
        Self::bump(amplitude_px, [0.0].into_iter().chain(cycles))
    }

    /// A gel that is pressed when tracking begins, released, at rest for a while, and pressed again.
    #[must_use]
    pub fn pressed_start(amplitude_px: f64) -> Self {
        let holding = [1.0; HOLDING_FRAMES].into_iter();
        let release = (0..RELEASE_FRAMES).map(|frame| 1.0 - frame as f64 / RELEASE_FRAMES as f64);
        let resting = [0.0; RESTING_FRAMES].into_iter();
        let press = (0..=RELEASE_FRAMES).map(|frame| frame as f64 / RELEASE_FRAMES as f64);
        Self::bump(amplitude_px, holding.chain(release).chain(resting).chain(press))
    }

    /// A small gel that creeps by 0.02 px a frame while the light falls by 15 %, over 300 frames.
    #[must_use]
    pub fn drift() -> Self {
        let sheet = Sheet { width: 240, height: 180, ..Sheet::default() };
        let step = |frame: u32| Step {
            sequence: u64::from(frame),
            motion: Motion::shift(0.02 * f64::from(frame)),
            light: Light::uniform(1.0 - 0.15 * frame as f32 / 300.0),
        };
        Self { sheet, steps: (0..=300).map(step).collect() }
    }

    fn bump(amplitude_px: f64, fractions: impl Iterator<Item = f64>) -> Self {
        let sheet = Sheet::default();
        let bump = Motion::radial_bump(sheet.centre_px(), amplitude_px);
        let steps = fractions.enumerate().map(|(frame, fraction)| Step {
            sequence: frame as u64,
            motion: bump.at(fraction),
            light: Light::EVEN,
        });
        Self { sheet, steps: steps.collect() }
    }

    /// The same under light that tilts with time, to −15 % at the left border and +15 % at the right one.
    #[must_use]
    pub fn with_light(mut self) -> Self {
        let last = self.steps.len().saturating_sub(1).max(1) as f32;
        for (frame, step) in self.steps.iter_mut().enumerate() {
            let part = frame as f32 / last;
            let gain = |full: f32| 1.0 + part * (full - 1.0);
            step.light = Light { left: gain(TILTED_LIGHT.left), right: gain(TILTED_LIGHT.right) };
        }
        self
    }

    /// The same with only every n-th frame.
    #[must_use]
    pub fn every(mut self, frames: usize) -> Self {
        self.steps = self.steps.into_iter().step_by(frames).collect();
        self
    }

    /// Renders all frames, each with independent noise.
    ///
    /// # Errors
    ///
    /// [`EvaluateError::Gel`] if a motion folds.
    pub fn frames(&self) -> Result<Vec<Frame>, EvaluateError> {
        let renderer = SheetRenderer::new(&self.sheet)?;
        let frame = |step: &Step| {
            let image = renderer.render(&step.motion, step.light, 1 + step.sequence)?;
            let capture_time_s = step.sequence as f64 / RATE_HZ;
            Ok(Frame { sequence: step.sequence, capture_time_s, pixels: Pixels::Rgb8(image) })
        };
        self.steps.par_iter().map(frame).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn amplitudes(script: &Script) -> Vec<f64> {
        let amplitude = |step: &Step| match step.motion {
            Motion::RadialBump { amplitude_px, .. } => amplitude_px,
            _ => f64::NAN,
        };
        script.steps.iter().map(amplitude).collect()
    }

    #[test]
    fn presses_come_back() {
        let found = amplitudes(&Script::presses(4.0, 2, 2));
        let expected = [0.0, 2.0, 4.0, 2.0, 0.0, 2.0, 4.0, 2.0, 0.0];
        assert_eq!(found.len(), expected.len());
        assert!(found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-12), "{found:?}");
    }

    #[test]
    fn dropped_frames_leave_gaps_in_the_count() {
        let script = Script::press(25.0, 30).every(5);
        let sequences: Vec<_> = script.steps.iter().map(|step| step.sequence).collect();
        assert_eq!(sequences, [0, 5, 10, 15, 20, 25, 30]);
    }

    #[test]
    fn a_start_under_pressure_is_released_in_time() {
        let found = amplitudes(&Script::pressed_start(10.0));
        assert!((found[0] - 10.0).abs() < 1e-12 && (found[found.len() - 1] - 10.0).abs() < 1e-12);
        assert!(found[RELEASED].abs() < 1e-12 && found[RELEASED - 1] > 0.0);
    }

    #[test]
    fn light_tilts_to_the_end() {
        let script = Script::press(1.0, 4).with_light();
        assert_eq!(script.steps[0].light, Light::EVEN);
        let last = script.steps[4].light;
        assert!((last.left - 0.85).abs() < 1e-6 && (last.right - 1.15).abs() < 1e-6);
    }
}

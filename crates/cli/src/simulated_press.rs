//! A press on a simulated gel, with its truth: tracked by demo, bench and doctor, without any hardware.

use fingervision_gel::{GelError, Light, Motion, Sheet, SheetRenderer};
use fingervision_image::{Frame, Pixels};
use fingervision_source::{Source, SourceError};

/// Rate of the simulated camera, frames per second.
const FRAMES_PER_SECOND: f64 = 30.0;

/// The course of a press: a motion that grows from zero and returns to zero.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Press {
    /// The motion half-way through.
    pub(crate) deepest: Motion,
    /// Frames from rest to rest.
    pub(crate) frames: u64,
}

impl Press {
    /// The motion of a frame; it begins, turns and ends smoothly.
    pub(crate) fn motion(&self, frame: u64) -> Motion {
        let phase = frame as f64 / (self.frames.max(2) - 1) as f64;
        self.deepest.at(0.5 - 0.5 * (std::f64::consts::TAU * phase).cos())
    }
}

/// The camera's images of a press on a dense random colour pattern.
#[derive(Debug)]
pub(crate) struct SimulatedPress {
    renderer: SheetRenderer,
    press: Press,
    next: u64,
}

impl SimulatedPress {
    /// A press of `frames` frames by a round bump: its largest displacement, `amplitude_px`, lies `radius_px` from the
    /// image centre.
    ///
    /// # Errors
    ///
    /// [`GelError::OutOfRange`] if the image has no pixels.
    pub(crate) fn new(
        (width, height): (usize, usize),
        radius_px: f64,
        amplitude_px: f64,
        frames: u64,
    ) -> Result<Self, GelError> {
        let renderer = SheetRenderer::new(&Sheet { width, height, ..Sheet::default() })?;
        let centre_px = renderer.sheet().centre_px();
        let deepest = Motion::RadialBump { centre_px, radius_px, amplitude_px };
        Ok(Self { renderer, press: Press { deepest, frames }, next: 0 })
    }

    pub(crate) fn press(&self) -> Press {
        self.press
    }

    /// A frame of the press.
    ///
    /// # Errors
    ///
    /// [`GelError::Folds`] if the amplitude is too large for the radius.
    pub(crate) fn frame(&self, sequence: u64) -> Result<Frame, GelError> {
        let image = self.renderer.render(&self.press.motion(sequence), Light::EVEN, sequence)?;
        Ok(Frame { sequence, capture_time_s: sequence as f64 / FRAMES_PER_SECOND, pixels: Pixels::Rgb8(image) })
    }
}

impl Source for SimulatedPress {
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        let sequence = self.next;
        if sequence >= self.press.frames {
            return Ok(None);
        }
        let frame = self.frame(sequence);
        self.next = if frame.is_ok() { sequence + 1 } else { self.press.frames };
        frame.map(Some).map_err(|error| {
            let (path, reason) = ("simulated press".into(), error.to_string());
            SourceError::Frame { path, sequence, reason }
        })
    }

    fn frame_count(&self) -> Option<u64> {
        Some(self.press.frames)
    }

    fn size(&self) -> (usize, usize) {
        (self.renderer.sheet().width, self.renderer.sheet().height)
    }

    fn description(&self) -> String {
        let ((width, height), count) = (self.size(), self.press.frames);
        format!(
            "simulated press: {count} images, {width}x{height} px 8-bit colour, {FRAMES_PER_SECOND} frames per second"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_press_begins_and_ends_at_rest() {
        let press = SimulatedPress::new((40, 30), 12.0, 3.0, 9).unwrap().press();
        for (frame, expected) in [(0, 0.0), (4, 3.0), (8, 0.0)] {
            let (u, _) = press.motion(frame).displacement(19.5 + 12.0, 14.5);
            assert!((u - expected).abs() < 1e-9, "frame {frame}: {u} px, expected {expected} px");
        }
    }

    #[test]
    fn all_frames_come_in_order() {
        let mut source = SimulatedPress::new((40, 30), 12.0, 3.0, 3).unwrap();
        let frames = std::iter::from_fn(|| source.next_frame().unwrap());
        assert_eq!(frames.map(|frame| frame.sequence).collect::<Vec<_>>(), [0, 1, 2]);
        assert!(source.next_frame().unwrap().is_none());
    }
}

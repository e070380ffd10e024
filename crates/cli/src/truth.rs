//! How far the readings of a simulated press are from its truth.

use std::fmt;

use fingervision_gel::Motion;
use fingervision_image::Frame;
use fingervision_sink::{Sink, SinkError};
use fingervision_touch::Reading;
use serde::Serialize;

use crate::simulated_press::Press;

/// Compares every reading with the motion that was drawn.
#[derive(Debug)]
pub(crate) struct TruthComparison {
    press: Press,
    frames: Vec<FrameError>,
}

/// How one reading differs from its truth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct FrameError {
    /// Mean distance between the displacement found and the true one over the valid pixels, px; NaN where none is.
    pub(crate) mean_px: f64,
    /// Part of the pixels that are valid, 0 to 1.
    pub(crate) valid: f64,
    /// Largest true displacement, px.
    pub(crate) largest_motion_px: f64,
}

/// What a comparison came to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct TruthReport {
    /// Mean end-point error of all frames, px.
    pub(crate) mean_error_px: f64,
    /// The frame that moved farthest.
    pub(crate) deepest: FrameError,
}

impl TruthComparison {
    pub(crate) fn new(press: Press) -> Self {
        Self { press, frames: Vec::new() }
    }

    /// What it came to; absent if no frame was compared.
    pub(crate) fn report(&self) -> Option<TruthReport> {
        let by_motion = |a: &&FrameError, b: &&FrameError| a.largest_motion_px.total_cmp(&b.largest_motion_px);
        let deepest = *self.frames.iter().max_by(by_motion)?;
        let mean_error_px = self.frames.iter().map(|frame| frame.mean_px).sum::<f64>() / self.frames.len() as f64;
        Some(TruthReport { mean_error_px, deepest })
    }
}

impl Sink for TruthComparison {
    fn write(&mut self, reading: &Reading, frame: &Frame) -> Result<(), SinkError> {
        self.frames.push(frame_error(reading, &self.press.motion(frame.sequence)));
        Ok(())
    }
}

/// How a reading differs from the motion that was drawn.
pub(crate) fn frame_error(reading: &Reading, motion: &Motion) -> FrameError {
    let (width, height) = reading.flow.size();
    let (mut sum, mut count, mut largest_motion_px) = (0.0, 0.0, 0.0_f64);
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let (u, v) = motion.displacement(x as f64, y as f64);
        largest_motion_px = largest_motion_px.max(u.hypot(v));
        if reading.valid.at(x, y) == 1 {
            let (found_u, found_v) = (f64::from(reading.flow.u.at(x, y)), f64::from(reading.flow.v.at(x, y)));
            sum += (found_u - u).hypot(found_v - v);
            count += 1.0;
        }
    }
    FrameError { mean_px: sum / count, valid: count / (width * height) as f64, largest_motion_px }
}

impl fmt::Display for TruthReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let FrameError { mean_px, valid, largest_motion_px } = self.deepest;
        let percent = 100.0 * valid;
        write!(f, "truth    flow is off by {:.3} px on average, ", self.mean_error_px)?;
        writeln!(
            f,
            "by {mean_px:.3} px where the press of {largest_motion_px:.1} px is deepest ({percent:.0} % of it valid)"
        )
    }
}

//! Errors of a reading of a simulated press, compared with its truth.

use fingervision_gel::Motion;
use fingervision_touch::Reading;

/// The errors of one reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FrameError {
    /// Mean distance between the measured displacement and the true one over the valid pixels, px; NaN if none is
    /// valid.
    pub(crate) mean_px: f64,
    /// Part of the pixels that are valid, 0 to 1.
    pub(crate) valid: f64,
    /// Largest true displacement, px.
    pub(crate) largest_motion_px: f64,
}

/// Compares a reading with the motion with which its image was rendered.
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

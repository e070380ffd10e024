//! A press of known depth, prepared for the fit: tracked, with the flow of a few of its frames stored.

use fingervision_flow::FlowField;
use fingervision_image::{Frame, Image};
use fingervision_touch::{Fields, Flag, Profile, Tracker};

use crate::depth::{DepthFitError, check_camera, check_depths, tracking};

use super::GelFitError;
use super::thresholds::THRESHOLDS;

/// Frames of a press that are kept.
const FRAMES: usize = 4;

/// A tracked press.
#[derive(Debug, Clone)]
pub struct GelPress {
    /// Its name.
    pub name: String,
    pub(super) frames: Vec<PressedFrame>,
    /// Columns and rows of the flow, px.
    pub(super) size: (usize, usize),
    /// Whether its first motion is a release.
    pub(super) was_released: bool,
}

/// One frame of a press.
#[derive(Debug, Clone)]
pub(super) struct PressedFrame {
    pub(super) depth_mm: f64,
    pub(super) force_n: Option<f64>,
    pub(super) flow: FlowField,
    pub(super) deviation: Image<f32>,
    pub(super) valid: Image<u8>,
}

/// Tracks a press.
#[derive(Debug)]
pub struct GelPressRecorder {
    press: GelPress,
    depths_mm: Vec<f64>,
    forces_n: Option<Vec<f64>>,
    tracker: Tracker,
    chosen: Vec<usize>,
    seen: usize,
    lost: usize,
}

impl GelPressRecorder {
    /// A recorder for a press with images of this size, px, known depths, mm, and possibly normal forces, N.
    ///
    /// # Errors
    ///
    /// [`GelFitError`] if the depths are not those of a press, or too deep or too shallow for linear elasticity, or the
    /// profile does not fit the images.
    ///
    /// # Panics
    ///
    /// If there are not as many forces as depths.
    pub fn new(
        name: &str,
        depths_mm: &[f64],
        forces_n: Option<&[f64]>,
        profile: &Profile,
        frame_size: (usize, usize),
        is_colour: bool,
    ) -> Result<Self, GelFitError> {
        assert!(forces_n.is_none_or(|forces| forces.len() == depths_mm.len()), "one force a depth");
        let gel = profile.gel.ok_or(GelFitError::Absent { table: "gel" })?;
        profile.camera.ok_or(GelFitError::Absent { table: "camera" })?;
        check_depths(name, depths_mm, profile)?;
        let range_mm = THRESHOLDS.depths.map(|part| part * gel.thickness_mm);
        let chosen = choose(depths_mm, range_mm);
        if chosen.is_empty() {
            let deepest_mm = depths_mm.iter().copied().fold(0.0, f64::max);
            return Err(GelFitError::NoDepth { press: name.into(), range_mm, deepest_mm });
        }
        let mut profile = profile.clone();
        // By the depths, the first image shows the gel at rest: it stays the reference.
        profile.references.rest_frames = u64::MAX;
        let tracker = Tracker::new(&profile, frame_size, is_colour, Fields::NONE).map_err(tracking(name))?;
        let size = tracker.size();
        check_camera(name, &profile, size)?;
        Ok(Self {
            press: GelPress { name: name.into(), frames: Vec::with_capacity(chosen.len()), size, was_released: false },
            depths_mm: depths_mm.to_vec(),
            forces_n: forces_n.map(<[f64]>::to_vec),
            tracker,
            chosen,
            seen: 0,
            lost: 0,
        })
    }

    /// Takes the next image. Returns whether more are needed: images after the last stored frame are not tracked.
    ///
    /// # Errors
    ///
    /// [`GelFitError::Press`] if it cannot be tracked.
    pub fn push(&mut self, frame: &Frame) -> Result<bool, GelFitError> {
        let name = &self.press.name;
        let reading = self.tracker.track(frame).map_err(tracking(name))?;
        self.press.was_released |= reading.flags.has(Flag::PressedAtStart);
        let number = self.seen;
        self.seen += 1;
        if self.chosen.contains(&number) {
            if [Flag::Lost, Flag::NoTexture, Flag::TornImage].iter().any(|&flag| reading.flags.has(flag)) {
                self.lost += 1;
            } else {
                self.press.frames.push(PressedFrame {
                    depth_mm: self.depths_mm[number],
                    force_n: self.forces_n.as_ref().map(|forces| forces[number]),
                    flow: reading.flow.clone(),
                    deviation: reading.deviation.clone(),
                    valid: reading.valid.clone(),
                });
            }
        }
        Ok(self.chosen.iter().any(|&chosen| chosen >= self.seen))
    }

    /// The press, after the last image that is needed.
    ///
    /// # Errors
    ///
    /// [`GelFitError::Press`] if images are missing or half of the stored ones were lost.
    pub fn finish(self) -> Result<GelPress, GelFitError> {
        let (press, kept) = (self.press.name.clone(), self.chosen.len());
        if self.chosen.iter().any(|&chosen| chosen >= self.seen) {
            let depths = self.depths_mm.len() as u64;
            return Err(DepthFitError::Count { press, images: self.seen as u64, depths }.into());
        }
        if 2 * self.lost > kept {
            return Err(DepthFitError::Lost { press, lost: self.lost, frames: kept }.into());
        }
        Ok(self.press)
    }
}

/// The first frames whose depths are nearest to even steps through a range.
fn choose(depths_mm: &[f64], [low, high]: [f64; 2]) -> Vec<usize> {
    let within = |&frame: &usize| (low..=high).contains(&depths_mm[frame]);
    let mut chosen: Vec<usize> = Vec::with_capacity(FRAMES);
    for step in 0..FRAMES {
        let wanted = low + (high - low) * step as f64 / (FRAMES - 1) as f64;
        let far = |frame: &usize| (depths_mm[*frame] - wanted).abs();
        let nearest = (0..depths_mm.len()).filter(within).min_by(|a, b| far(a).total_cmp(&far(b)));
        chosen.extend(nearest.filter(|frame| !chosen.contains(frame)));
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_spread_over_the_linear_range() {
        let depths: Vec<f64> = (0..21).map(|frame| 0.1 * f64::from(frame)).collect();
        assert_eq!(choose(&depths, [0.39, 1.31]), [4, 7, 10, 13]);
        assert_eq!(choose(&[0.0, 0.5, 2.0], [0.39, 1.31]), [1]);
        assert_eq!(choose(&[0.0, 0.1, 2.0], [0.39, 1.31]), [0; 0]);
    }
}

//! The board that slides in known steps.

use fingervision_flow::FlowParams;
use fingervision_image::{Frame, Rect};

use super::Check;
use super::exposure::Exposure;
use super::fault::{Fault, RecordingCheck, What};
use super::samples::{Samples, unsharp};
use super::thresholds::THRESHOLDS;
use crate::camera::{BoardError, BoardTracker, Slide};

/// The published number of images: 20 steps, whose mean has a quarter of one step's noise.
pub const BOARD_IMAGES: usize = 21;

/// Checks a recording of the sliding board.
#[derive(Debug)]
pub struct BoardCheck {
    exposure: Exposure,
    tracker: BoardTracker,
    slide: Slide,
    least_side: usize,
    /// Median deviation of the worst pair, px; none before there is one.
    deviation_px: Option<f64>,
    /// What is wrong with the images so far: once there is a fault, further images are not tracked.
    fault: Option<Fault>,
}

impl BoardCheck {
    /// A check of the region of interest of frames in grey or colour, for a board with this slide.
    ///
    /// # Errors
    ///
    /// [`BoardError::Flow`] for a region too small or parameters out of range.
    pub fn new(region: Rect, is_colour: bool, params: &FlowParams, slide: Slide) -> Result<Self, BoardError> {
        Ok(Self {
            exposure: Exposure::new(region, false),
            tracker: BoardTracker::new(region, is_colour, params)?,
            slide,
            least_side: region.width.min(region.height),
            deviation_px: None,
            fault: None,
        })
    }

    fn count_fault(&self) -> Option<Fault> {
        let images = self.exposure.images();
        let error = BoardError::TooFewImages { images };
        let measured = format!("{images} images");
        (images < BOARD_IMAGES).then(|| {
            Fault::new(What::Count, measured, format!("at least {BOARD_IMAGES}"), error.hint().unwrap_or_default())
        })
    }

    /// The usual step, px, or what is wrong with the steps; a recording too short has neither.
    fn steps(&self) -> Result<Option<f64>, Fault> {
        if let Some(fault) = &self.fault {
            return Err(fault.clone());
        }
        let length = match self.tracker.finish(self.slide, None) {
            Ok(flow) => flow.usual_px[0].hypot(flow.usual_px[1]),
            Err(BoardError::TooFewImages { .. }) => return Ok(None),
            Err(error) => return Err((&error).into()),
        };
        let measured = format!("the board moves by {length:.2} px a step");
        let largest = THRESHOLDS.most_step * self.least_side as f64;
        if length < THRESHOLDS.least_step_px {
            let remedy =
                "take a longer step and give its length with --step-mm: it should move the board by 3 to 30 px";
            return Err(Fault::new(
                What::StepTooSmall,
                measured,
                format!("at least {} px", THRESHOLDS.least_step_px),
                remedy,
            ));
        }
        if length > largest {
            let remedy =
                "take a shorter step and give its length with --step-mm: it should move the board by 3 to 30 px";
            return Err(Fault::new(What::StepTooLarge, measured, format!("at most {largest:.0} px"), remedy));
        }
        Ok(Some(length))
    }
}

impl Check for BoardCheck {
    fn push(&mut self, frame: &Frame) {
        self.exposure.push(frame);
        self.fault = self.fault.take().or_else(|| self.exposure.fault());
        if self.fault.is_some() {
            return;
        }
        if let Err(error) = self.tracker.push(frame) {
            self.fault = Some((&error).into());
        } else if let Some(estimate) = self.tracker.last_pair() {
            let samples = Samples::of(&estimate.flow, &estimate.deviation, &estimate.valid);
            self.deviation_px = Some(self.deviation_px.unwrap_or(0.0).max(samples.deviation_px));
            self.fault = unsharp(samples.deviation_px);
        }
    }

    fn finish(self: Box<Self>) -> RecordingCheck {
        let steps = self.steps();
        let motion_px = steps.as_ref().ok().copied().flatten();
        RecordingCheck {
            deviation_px: self.deviation_px.filter(|deviation| deviation.is_finite()),
            motion_px,
            faults: self.count_fault().into_iter().chain(steps.err()).collect(),
            ..self.exposure.figures()
        }
    }
}

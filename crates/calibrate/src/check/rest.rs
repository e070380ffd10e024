//! Compares the first image of a recording with the untouched gel of another recording.

use fingervision_flow::{Estimate, FlowEstimator, FlowParams, Picture, Reference, Start};
use fingervision_image::{Frame, Rect};

use super::fault::{Fault, What};
use super::samples::Samples;
use super::thresholds::THRESHOLDS;

/// The untouched gel.
#[derive(Debug)]
pub(super) struct RestImage {
    region: Rect,
    estimator: FlowEstimator,
    reference: Reference,
    picture: Picture,
    estimate: Estimate,
}

impl RestImage {
    /// The region of an image that shows the untouched gel, for frames in grey or colour.
    ///
    /// # Errors
    ///
    /// Why no image can be compared with it.
    pub(super) fn new(frame: &Frame, region: Rect, is_colour: bool, params: &FlowParams) -> Result<Self, Fault> {
        let params = FlowParams { colour: params.colour && is_colour, ..*params };
        let estimator = FlowEstimator::new(region.width, region.height, &params)
            .map_err(|error| Fault::unreadable(&error, None))?;
        let (mut picture, mut reference) = (estimator.picture(), estimator.reference());
        picture.load(&frame.pixels, region).map_err(|error| Fault::unreadable(&error, None))?;
        estimator.prepare(&picture, &mut reference);
        let estimate = Estimate::new(region.width, region.height);
        Ok(Self { region, estimator, reference, picture, estimate })
    }

    /// What is wrong with the first image of a press on this gel, if anything.
    pub(super) fn fault(&mut self, first: &Frame) -> Option<Fault> {
        // An image that cannot be loaded is reported by the caller that tracks it.
        self.picture.load(&first.pixels, self.region).ok()?;
        self.estimator.estimate(&self.reference, &self.picture, Start::Search(None), &mut self.estimate);
        let matched = self.estimate.matched;
        if matched < THRESHOLDS.least_matched_at_rest {
            let measured =
                format!("only {:.0} % of the first image matches the image of the untouched gel", 100.0 * matched);
            let remedy = "put a recording of this sensor here, or record still again if camera or gel were changed";
            return Some(Fault::new(What::OtherSensor, measured, "the same gel and the same camera", remedy));
        }
        let samples = Samples::of(&self.estimate.flow, &self.estimate.deviation, &self.estimate.valid);
        let [x, y] = samples.median();
        let shift = x.hypot(y);
        if shift > THRESHOLDS.most_shift_px {
            let measured = format!("the first image is shifted by {shift:.1} px from that of the untouched gel");
            let remedy = "fix camera, lens and gel in one rigid frame, then record still and the presses again";
            return Some(Fault::new(What::Drift, measured, format!("at most {} px", THRESHOLDS.most_shift_px), remedy));
        }
        let motion = samples.apart_from([x, y], THRESHOLDS.moving_part);
        let measured =
            format!("in the first image a part of the gel is displaced by {motion:.1} px from the untouched gel");
        let remedy = "begin the recording before the indenter touches the gel, and check that the images are in order";
        let allowed = format!("at most {} px", THRESHOLDS.most_motion_at_rest_px);
        (motion > THRESHOLDS.most_motion_at_rest_px)
            .then(|| Fault::new(What::PressedAtStart, measured, allowed, remedy))
    }
}

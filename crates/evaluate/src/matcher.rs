//! Flow between two images, without a start from an earlier frame.

use crate::EvaluateError;
use fingervision_flow::{Estimate, FlowEstimator, FlowParams, Picture, Reference, Start};
use fingervision_image::{Pixels, Rect};

/// Matches images with one reference.
pub(crate) struct Matcher {
    estimator: FlowEstimator,
    reference: Reference,
    picture: Picture,
    estimate: Estimate,
}

impl Matcher {
    pub(crate) fn new(reference: &Pixels, params: &FlowParams) -> Result<Self, EvaluateError> {
        let (width, height) = reference.size();
        let colour = params.colour && reference.is_colour();
        let estimator = FlowEstimator::new(width, height, &FlowParams { colour, ..*params })?;
        let mut matcher = Self {
            reference: estimator.reference(),
            picture: estimator.picture(),
            estimate: Estimate::new(width, height),
            estimator,
        };
        matcher.set_reference(reference)?;
        Ok(matcher)
    }

    /// Matches all further images with this one, of the same size.
    pub(crate) fn set_reference(&mut self, reference: &Pixels) -> Result<(), EvaluateError> {
        self.load(reference)?;
        self.estimator.prepare(&self.picture, &mut self.reference);
        Ok(())
    }

    /// The flow to an image, by a search without a start.
    pub(crate) fn find(&mut self, current: &Pixels) -> Result<&Estimate, EvaluateError> {
        self.load(current)?;
        self.estimator.estimate(&self.reference, &self.picture, Start::Search(None), &mut self.estimate);
        Ok(&self.estimate)
    }

    fn load(&mut self, pixels: &Pixels) -> Result<(), EvaluateError> {
        let (width, height) = pixels.size();
        Ok(self.picture.load(pixels, Rect::whole(width, height))?)
    }
}

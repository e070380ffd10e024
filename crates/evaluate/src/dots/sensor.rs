//! From images of dots to the density feature.

use fingervision_flow::FlowField;
use fingervision_image::{Image, Pixels};
use fingervision_touch::{DensityEstimator, DensityField, DensityParams, GuidedFilter};

use super::{DotError, DotTracker};

/// Every field that one image of dots gives, on the grid of the first image.
#[derive(Debug, Clone, Copy)]
pub struct DotTouch<'a> {
    /// Displacement, px.
    pub flow: &'a FlowField,
    /// The density feature `1 − density` after the filter, dimensionless; a depth law takes it from here.
    pub feature: &'a Image<f32>,
    /// 1 where both hold, 0 elsewhere.
    pub valid: &'a Image<u8>,
    /// Dots that are not found.
    pub lost: usize,
}

/// A sensor whose pattern is dots.
#[derive(Debug, Clone)]
pub struct DotSensor {
    tracker: DotTracker,
    estimator: DensityEstimator,
    filter: GuidedFilter,
    field: DensityField,
    feature: Image<f32>,
}

impl DotSensor {
    /// A sensor that measures from this image on.
    ///
    /// # Errors
    ///
    /// As [`DotTracker::new`], and [`DotError::Parameter`] for a parameter out of range.
    pub fn new(first: &Pixels, params: &DensityParams) -> Result<Self, DotError> {
        let (width, height) = first.size();
        Ok(Self {
            tracker: DotTracker::new(first)?,
            estimator: DensityEstimator::new(width, height, params)?,
            filter: GuidedFilter::new(width, height, &params.filter)?,
            field: DensityField::at_rest(width, height),
            feature: Image::filled(width, height, 0.0),
        })
    }

    /// The dots.
    #[must_use]
    pub fn tracker(&self) -> &DotTracker {
        &self.tracker
    }

    /// The fields of the next image.
    ///
    /// # Errors
    ///
    /// As [`DotTracker::track`].
    pub fn read(&mut self, image: &Pixels) -> Result<DotTouch<'_>, DotError> {
        let reading = self.tracker.track(image)?;
        self.estimator.estimate_into(&reading.flow, &mut self.field);
        self.filter.filter_into(&self.field.feature, &self.field.valid, &mut self.feature);
        Ok(DotTouch { flow: &reading.flow, feature: &self.feature, valid: &self.field.valid, lost: reading.lost })
    }
}

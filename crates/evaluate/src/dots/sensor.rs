//! Computes the density feature from images of dots.

use fingervision_flow::FlowField;
use fingervision_image::{Image, Pixels};
use fingervision_touch::DensityParams;

use super::{DotError, DotTracker};
use crate::filtered_density::FilteredDensity;

/// Every field that one image of dots gives, on the grid of the first image.
#[derive(Debug, Clone, Copy)]
pub struct DotTouch<'a> {
    /// Displacement, px.
    pub flow: &'a FlowField,
    /// The density feature `1 − density` after the filter, dimensionless; the input of a depth law.
    pub feature: &'a Image<f32>,
    /// 1 where both are valid, 0 elsewhere.
    pub valid: &'a Image<u8>,
    /// Dots that are not found.
    pub lost: usize,
}

/// A sensor whose pattern is dots.
#[derive(Debug, Clone)]
pub struct DotSensor {
    tracker: DotTracker,
    density: FilteredDensity,
}

impl DotSensor {
    /// A sensor whose first image is this one.
    ///
    /// # Errors
    ///
    /// As [`DotTracker::new`], and [`DotError::Parameter`] for a parameter out of range.
    pub fn new(first: &Pixels, params: &DensityParams) -> Result<Self, DotError> {
        Ok(Self { tracker: DotTracker::new(first)?, density: FilteredDensity::new(first.size(), params)? })
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
        self.density.update(&reading.flow);
        let (feature, valid) = (self.density.feature(), self.density.valid());
        Ok(DotTouch { flow: &reading.flow, feature, valid, lost: reading.lost })
    }
}

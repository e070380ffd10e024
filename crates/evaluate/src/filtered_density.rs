//! The filtered density feature of a flow, from any method.

use fingervision_flow::FlowField;
use fingervision_image::Image;
use fingervision_touch::{DensityEstimator, DensityField, DensityParams, GuidedFilter, ParameterError};

/// Density of a flow, filtered; owns its scratch.
#[derive(Debug, Clone)]
pub(crate) struct FilteredDensity {
    estimator: DensityEstimator,
    filter: GuidedFilter,
    field: DensityField,
    feature: Image<f32>,
}

impl FilteredDensity {
    /// For flows of this many columns and rows, px.
    pub(crate) fn new((width, height): (usize, usize), params: &DensityParams) -> Result<Self, ParameterError> {
        Ok(Self {
            estimator: DensityEstimator::new(width, height, params)?,
            filter: GuidedFilter::new(width, height, &params.filter)?,
            field: DensityField::at_rest(width, height),
            feature: Image::filled(width, height, 0.0),
        })
    }

    /// Takes the next flow.
    pub(crate) fn update(&mut self, flow: &FlowField) {
        self.estimator.estimate_into(flow, &mut self.field);
        self.filter.filter_into(&self.field.feature, &self.field.valid, &mut self.feature);
    }

    /// The density feature `1 − density` after the filter, dimensionless.
    pub(crate) fn feature(&self) -> &Image<f32> {
        &self.feature
    }

    /// 1 where the density is valid, 0 elsewhere.
    pub(crate) fn valid(&self) -> &Image<u8> {
        &self.field.valid
    }
}

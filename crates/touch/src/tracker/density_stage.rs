//! The density feature, and depth from it by a law.

use fingervision_image::Image;

use super::planes::largest_valid;
use crate::{DensityEstimator, DensityField, DepthLaw, DepthMap, Flag, GuidedFilter, Profile, Reading, TrackError};

/// Density, filter and depth.
#[derive(Debug)]
pub(super) struct DensityStage {
    estimator: DensityEstimator,
    filter: GuidedFilter,
    field: DensityField,
    to_depth: Option<DepthMap>,
}

impl DensityStage {
    /// A stage for this profile, with or without a depth law; allocates the planes of the reading that it will fill.
    ///
    /// # Errors
    ///
    /// [`TrackError`] if a parameter is impossible or the camera does not see the gel.
    pub(super) fn new(profile: &Profile, law: Option<DepthLaw>, reading: &mut Reading) -> Result<Self, TrackError> {
        let (width, height) = reading.flow.size();
        let to_depth = law
            .map(|law| DepthMap::new(&law, profile.camera.as_ref(), (width, height)).ok_or(TrackError::NoSurface))
            .transpose()?;
        reading.density = Some(Image::filled(width, height, 0.0));
        if to_depth.is_some() {
            reading.depth = Some(Image::filled(width, height, 0.0));
        }
        Ok(Self {
            estimator: DensityEstimator::new(width, height, &profile.density)?,
            filter: GuidedFilter::new(width, height, &profile.density.filter)?,
            field: DensityField::at_rest(width, height),
            to_depth,
        })
    }

    /// Fills the fields from the reading's flow.
    pub(super) fn run(&mut self, reading: &mut Reading) {
        self.estimator.estimate_into(&reading.flow, &mut self.field);
        if self.field.has_gap {
            reading.numbers.flags.raise(Flag::DensityGap);
        }
        for (valid, field) in reading.valid.values_mut().iter_mut().zip(self.field.valid.values()) {
            *valid &= field;
        }
        let Some(feature) = &mut reading.density else { return };
        self.filter.filter_into(&self.field.feature, &reading.valid, feature);
        if let (Some(to_depth), Some(depth)) = (&self.to_depth, &mut reading.depth) {
            to_depth.depth_into(feature, &mut reading.valid, depth);
            reading.numbers.max_depth_mm = largest_valid(depth, &reading.valid);
        }
    }
}

/// Density of readings, and depth from it, computed apart from tracking: a program can complete a reading while the next
/// frame is tracked. Made by [`Tracker::defer_density`](crate::Tracker::defer_density).
#[derive(Debug)]
pub struct DeferredDensity(pub(super) DensityStage);

impl DeferredDensity {
    /// Fills density, depth and validity of a reading, and its numbers that follow from them. The reading is then the one
    /// that the tracker would have given, bit for bit, apart from its latency.
    ///
    /// # Panics
    ///
    /// If the reading is from a tracker of another size.
    pub fn complete(&mut self, reading: &mut Reading) {
        self.0.run(reading);
    }
}

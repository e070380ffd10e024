//! From the density feature to depth by a fitted law.

use fingervision_calibrate::depth::{DepthFit, DepthFitError, Method};
use fingervision_image::Image;
use fingervision_touch::DepthMap;

use super::Recording;

/// Depth at every pixel of a feature by a fitted law, mm; 0 where the law has no slope.
///
/// # Errors
///
/// [`DepthFitError`] if the law is not available, or the camera does not see the surface.
pub fn depth_of(
    feature: &Image<f32>,
    fit: &DepthFit,
    method: Method,
    recording: &Recording,
) -> Result<Image<f32>, DepthFitError> {
    let (width, height) = feature.size();
    let camera = recording.profile.camera.as_ref();
    let map = DepthMap::new(&fit.law(method)?.law, camera, (width, height)).ok_or(DepthFitError::NoCamera)?;
    let mut depth = Image::filled(width, height, 0.0);
    map.depth_into(feature, &mut Image::filled(width, height, 1), &mut depth);
    Ok(depth)
}

/// The same depth with negative values set to 0.
#[must_use]
pub fn clipped(mut depth: Image<f32>) -> Image<f32> {
    depth.values_mut().iter_mut().for_each(|depth| *depth = depth.max(0.0));
    depth
}

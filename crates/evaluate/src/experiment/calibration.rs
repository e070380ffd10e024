//! The nine calibration presses of a sensor, tracked from their images.

use fingervision_calibrate::depth::{DepthFit, Maximum, MaximumFinder, Place, PressCurve, PressPoint};
use fingervision_gel::Scene;
use fingervision_image::Image;
use fingervision_touch::perspective_slopes_mm;
use rayon::prelude::*;

use super::{ExperimentError, Following, Recording, follow};

/// The nine presses and their positions on the gel: squares of 6 mm, 1, 2 and 3 mm deep.
pub const CALIBRATION: [(&str, Place); 9] = [
    ("calibration-centre-1mm", Place::Centre),
    ("calibration-centre-2mm", Place::Centre),
    ("calibration-centre-3mm", Place::Centre),
    ("calibration-midway-1mm", Place::Midway),
    ("calibration-midway-2mm", Place::Midway),
    ("calibration-midway-3mm", Place::Midway),
    ("calibration-corner-1mm", Place::Corner),
    ("calibration-corner-2mm", Place::Corner),
    ("calibration-corner-3mm", Place::Corner),
];

/// Fits depth laws to the nine presses of a sensor. `record` makes this sensor's recording of a ready-made scene.
///
/// # Errors
///
/// [`ExperimentError`] if a press cannot be solved or tracked, or no law fits.
pub fn calibrate(
    record: &(impl Fn(Scene) -> Result<Recording, ExperimentError> + Sync),
    following: Following,
) -> Result<DepthFit, ExperimentError> {
    let curve = |&(name, place): &(&str, Place)| curve(&record(Scene::find(name)?)?, place, following);
    let curves = CALIBRATION.par_iter().map(curve).collect::<Result<Vec<_>, _>>()?;
    Ok(DepthFit::new(curves)?)
}

/// The curve of a press: the largest feature of every frame (the published maximum) over the pixels with valid
/// displacement.
fn curve(recording: &Recording, place: Place, following: Following) -> Result<PressCurve, ExperimentError> {
    let camera = recording.profile.camera;
    let slopes = camera.and_then(|camera| perspective_slopes_mm(&camera, recording.size()));
    let mut finder = MaximumFinder::new(Maximum::Plain, recording.size());
    let (mut points, mut lost) = (Vec::new(), 0);
    follow(recording, &recording.profile, following, |number, found| {
        let perspective = slopes.as_ref().map(|slopes| scaled(found.feature, slopes));
        match finder.find(found.feature, found.valid) {
            Some(feature) => points.push(PressPoint {
                frame: number as u64,
                depth_mm: recording.depths_mm[number],
                feature: f64::from(feature),
                perspective_mm: perspective.and_then(|depth| finder.find(&depth, found.valid)).map(f64::from),
            }),
            None => lost += 1,
        }
    })?;
    Ok(PressCurve { name: recording.name.clone(), place, points, lost })
}

fn scaled(feature: &Image<f32>, slopes: &Image<f32>) -> Image<f32> {
    Image::from_fn(feature.width(), feature.height(), |x, y| feature.at(x, y) * slopes.at(x, y))
}

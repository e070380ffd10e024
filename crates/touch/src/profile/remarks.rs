//! Suspicious values of a profile, although every value is possible: a wrong unit, a camera that does not see the gel.

use fingervision_flow::FlowEstimator;
use serde::Serialize;

use super::view::View;
use super::{DepthMethod, Profile};
use crate::TRAINING_RANGE;

/// Usual angles of view of a lens across the region, degrees.
const ANGLES_DEGREES: std::ops::RangeInclusive<f64> = 5.0..=150.0;
/// If less than this part of the gel is visible, or less than this part of the region shows gel, the profile is
/// probably wrong.
const LEAST_PART: f64 = 0.2;
/// A principal point farther than this from the middle of the image, in longer sides of the image, is unusual: lenses
/// are mounted within a few per cent, and three times the standard deviation that a calibration assumes is 0.09.
const FARTHEST_AXIS: f64 = 0.1;
/// If more than this part of the region is beyond the range of the lens's distortion, its coefficients are wrong. Corners may be.
const MOST_BEYOND_LENS: f64 = 0.1;
/// A rotation vector longer than this, rad, is assumed to be in degrees.
const LARGEST_ROTATION_RAD: f64 = 0.6;

/// The severity of a remark.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Weight {
    /// Tracking fails, or its numbers are wrong.
    Fault,
    /// Possible, but probably not intended.
    Warning,
    /// Something is missing; the remark names the quantities that need it.
    Missing,
}

/// One remark on a profile.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Remark {
    /// Its severity.
    pub weight: Weight,
    /// The problem, with the value.
    pub message: String,
    /// What to do about it.
    pub hint: String,
}

impl Remark {
    fn new(weight: Weight, message: impl Into<String>, hint: impl Into<String>) -> Self {
        Self { weight, message: message.into(), hint: hint.into() }
    }
}

/// All remarks, faults first.
pub(super) fn all(profile: &Profile, view: &View, frame_size: Option<(usize, usize)>) -> Vec<Remark> {
    let mut remarks = does_not_fit(profile, view, frame_size);
    remarks.extend(lengths(profile));
    remarks.extend(principal_point(profile, view, frame_size));
    remarks.extend(lens(profile, view));
    remarks.extend(misses(view));
    remarks.extend(training_range(profile));
    remarks.extend(missing(profile));
    remarks.sort_by_key(|remark| remark.weight);
    remarks
}

/// The reason why a tracker cannot be made, if there is one.
fn does_not_fit(profile: &Profile, view: &View, frame_size: Option<(usize, usize)>) -> Vec<Remark> {
    let estimator = view.region.map(|region| FlowEstimator::new(region.width, region.height, &profile.flow));
    let size = estimator.and_then(Result::err).map(super::ProfileError::from);
    let region = frame_size.and_then(|size| profile.region(size).err());
    let is_elastic = profile.depth_method() == DepthMethod::Elastic;
    let elastic = is_elastic.then(|| profile.elastic_sensor().err()).flatten();
    let fault =
        |error: super::ProfileError| Remark::new(Weight::Fault, error.to_string(), error.hint().unwrap_or_default());
    region.or(size).into_iter().chain(elastic).map(fault).collect()
}

/// Values in another unit: 1000 times larger or smaller than those of a sensor.
fn lengths(profile: &Profile) -> Vec<Remark> {
    let mut checks = Vec::new();
    if let Some(gel) = profile.gel {
        let [width, height] = gel.size_mm;
        checks.push(("gel.size_mm", width, [2.0, 300.0], LENGTH));
        checks.push(("gel.size_mm", height, [2.0, 300.0], LENGTH));
        checks.push(("gel.thickness_mm", gel.thickness_mm, [0.3, 100.0], LENGTH));
        checks.extend(gel.youngs_modulus_mpa.map(|value| ("gel.youngs_modulus_mpa", value, [0.003, 30.0], STIFFNESS)));
    }
    if let Some(camera) = profile.camera {
        checks.push(("the distance camera.translation_mm[2]", camera.translation_mm[2], [1.0, 1000.0], LENGTH));
    }
    let mut remarks: Vec<Remark> =
        checks.into_iter().filter_map(|(key, value, range, unit)| slip(key, value, range, unit)).collect();
    remarks.dedup();
    remarks
}

/// A unit and the units it is confused with: 1000 times smaller, 1000 times larger.
type Unit = [&'static str; 3];
const LENGTH: Unit = ["mm", "µm", "m"];
const STIFFNESS: Unit = ["MPa", "kPa", "GPa"];

fn slip(key: &str, value: f64, [least, most]: [f64; 2], [unit, smaller, larger]: Unit) -> Option<Remark> {
    if (least..=most).contains(&value) {
        return None;
    }
    let meant = [(value / 1000.0, smaller), (value * 1000.0, larger)];
    let hint = match meant.into_iter().find(|(meant, _)| (least..=most).contains(meant)) {
        Some((meant, given_in)) => format!("the unit is {unit}: write {} if this is in {given_in}", rounded(meant)),
        None => format!("the unit is {unit}: measure it again"),
    };
    let message = format!("{key} = {value} {unit} is unusual for a sensor: usual are {least} to {most} {unit}");
    Some(Remark::new(Weight::Fault, message, hint))
}

/// The value without the digits that a factor of 1000 adds.
fn rounded(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}

/// A principal point far from the middle of the image, or of the region if the image's size is not known.
fn principal_point(profile: &Profile, view: &View, frame_size: Option<(usize, usize)>) -> Option<Remark> {
    let ([x, y], region) = (profile.camera?.principal_point_px, view.region?);
    let (what, (width, height), begin) = match frame_size {
        Some(size) => ("image", size, [region.x, region.y]),
        None => ("region", (region.width, region.height), [0, 0]),
    };
    let middle = |side: usize| 0.5 * (side as f64 - 1.0);
    let [off_x, off_y] = [x + begin[0] as f64 - middle(width), y + begin[1] as f64 - middle(height)];
    let (off_px, side) = (off_x.hypot(off_y), width.max(height) as f64);
    if off_px <= FARTHEST_AXIS * side {
        return None;
    }
    let message = format!(
        "camera.principal_point_px = [{x}, {y}] is {off_px:.0} px from the middle of the {what} of {width}x{height} px, usual \
         are at most {:.0} px",
        FARTHEST_AXIS * side
    );
    let elsewhere = match frame_size {
        Some(_) => "",
        None => {
            "; if the region is not in the middle of the camera's image, check with a recording, which gives the image's size"
        }
    };
    let [calibrated_width, calibrated_height] = [x + begin[0] as f64, y + begin[1] as f64].map(|at| 2.0 * at + 1.0);
    let hint = format!(
        "it is in px of the region of interest: subtract the region's x and y from the position in the camera's image; or use \
         images of the size with which the camera was calibrated, perhaps {calibrated_width:.0}x{calibrated_height:.0} px"
    );
    Some(Remark::new(Weight::Warning, message, format!("{hint}{elsewhere}")))
}

/// Focal length and rotation.
fn lens(profile: &Profile, view: &View) -> Vec<Remark> {
    let Some(camera) = profile.camera else { return Vec::new() };
    let mut remarks = Vec::new();
    let [fx, fy] = camera.focal_length_px;
    if let Some(region) = view.region {
        let width = region.width as f64;
        let angle = 2.0 * (0.5 * width / fx).atan().to_degrees();
        if !ANGLES_DEGREES.contains(&angle) {
            remarks.push(Remark::new(
                Weight::Fault,
                format!("camera.focal_length_px = {fx} px means an angle of view of {angle:.1}° across a region of {width} px"),
                "the focal length is in px of the image: that of the lens in mm divided by the size of a pixel on the chip in mm",
            ));
        }
    }
    let beyond = view.beyond_lens.unwrap_or(0.0);
    if beyond > 0.0 {
        let message =
            format!("the distortion folds the image: {:.0} % of the region is beyond its range", 100.0 * beyond);
        let hint = "that part is not measured: check [camera.distortion] and focal_length_px, or calibrate with points in the whole image";
        remarks.push(Remark::new(
            if beyond > MOST_BEYOND_LENS { Weight::Fault } else { Weight::Warning },
            message,
            hint,
        ));
    }
    if (fx / fy).max(fy / fx) > 1.25 {
        let message = format!("camera.focal_length_px = [{fx}, {fy}] px means that pixels are not square");
        remarks.push(Remark::new(Weight::Warning, message, "both are nearly equal for a usual camera"));
    }
    let rotation = camera.rotation_rad.iter().map(|value| value * value).sum::<f64>().sqrt();
    if rotation > LARGEST_ROTATION_RAD {
        let message = format!("camera.rotation_rad rotates the gel by {:.0}°", rotation.to_degrees());
        remarks.push(Remark::new(Weight::Warning, message, "it is in rad: 1° is 0.01745 rad"));
    }
    remarks
}

/// A camera that does not see enough of the gel.
fn misses(view: &View) -> Option<Remark> {
    let (gel_seen, region_on_gel) = view.gel_seen.zip(view.region_on_gel)?;
    let percent = |part: f64| 100.0 * part;
    let hint = "check gel.size_mm (mm), and of [camera] focal_length_px (px), principal_point_px (px of the region) and \
                translation_mm (mm, x, y and distance to the gel's centre)";
    if gel_seen == 0.0 || region_on_gel == 0.0 {
        return Some(Remark::new(Weight::Fault, "the camera does not see the gel's surface", hint));
    }
    if gel_seen < LEAST_PART {
        let message = format!("the camera sees {:.0} % of the gel's surface", percent(gel_seen));
        return Some(Remark::new(Weight::Warning, message, hint));
    }
    (region_on_gel < LEAST_PART).then(|| {
        let message = format!("{:.0} % of the region shows gel", percent(region_on_gel));
        Remark::new(Weight::Warning, message, format!("crop to the gel with image.region_of_interest, or {hint}"))
    })
}

fn training_range(profile: &Profile) -> Option<Remark> {
    (profile.is_outside_training_range() == Some(true)).then(|| {
        Remark::new(
            Weight::Warning,
            format!("gel and camera are outside the network's training range: {TRAINING_RANGE}"),
            "expect larger errors of depth than depth_deviation says; --set elastic.network=false switches the network off",
        )
    })
}

/// Missing parts, and the quantities that need them.
fn missing(profile: &Profile) -> Vec<Remark> {
    let mut remarks = Vec::new();
    let mut lacks = |message: &str, hint: &str| remarks.push(Remark::new(Weight::Missing, message, hint));
    if profile.depth.method == Some(DepthMethod::Density) {
        if profile.depth.density.is_none() {
            lacks("no depth.density: no depth", "fit it: fingervision calibrate depth PRESSES --profile FILE");
        }
        lacks(
            "depth.method = \"density\": no contact, no force",
            "leave depth.method out and describe [camera] and [gel]",
        );
        return remarks;
    }
    let without = if profile.depth.density.is_some() { "no contact and no force" } else { "no depth and no force" };
    if profile.camera.is_none() {
        let hint = "fit it: fingervision calibrate camera BOARD --step-mm 0.5 --profile FILE --prior distance_mm=25±0.5, with your own step and distance";
        lacks(&format!("no [camera]: {without}"), hint);
    }
    match profile.gel {
        None => lacks(
            &format!("no [gel]: {without}"),
            "measure size_mm and thickness_mm with calipers; poissons_ratio = 0.48 for silicone",
        ),
        Some(gel) if gel.youngs_modulus_mpa.is_none() => lacks(
            "no gel.youngs_modulus_mpa: no force",
            "fit it to presses of known force: fingervision calibrate gel PRESSES --profile FILE",
        ),
        Some(_) => {}
    }
    remarks
}

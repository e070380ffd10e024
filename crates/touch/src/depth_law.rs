//! From the density feature to depth: a fitted line, or the camera's perspective with a fitted gain.
//!
//! [Du2021] fits one line over presses of known depth. The feature follows the inverse of the surface's areal stretch,
//! so the line is a small-range approximation: deep presses read too shallow. It also treats any expansion as depth,
//! whatever caused it, so its slope depends on the place of the press; an intercept is added to every untouched pixel.
//!
//! [Du2021]: https://doi.org/10.1109/LRA.2021.3061306

use fingervision_image::Image;
use fingervision_optics::{Camera, CameraParams};
use serde::{Deserialize, Serialize};

use crate::ParameterError;

/// The relation from density feature to depth; a fit that belongs to one sensor.
///
/// In a profile it is a line, `density = { slope_mm = 15.2, intercept_mm = 0.0 }`, or the camera's perspective,
/// `density = { gain = 0.7 }`. A line through the origin has the intercept 0.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged, try_from = "Keys")]
pub enum DepthLaw {
    /// The same line everywhere, as published.
    Line(DepthLine),
    /// A line through the origin whose slope follows from the camera, pixel by pixel.
    Perspective(PerspectiveGain),
}

/// `depth = slope · feature + intercept`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct DepthLine {
    /// Depth per unit of the feature `1 − density`, mm.
    pub slope_mm: f64,
    /// Depth where the density is at rest, mm. It is added to every untouched pixel.
    pub intercept_mm: f64,
}

/// `depth = gain · feature / s(m)`, with `s(m)` the relative growth of a surface patch in the image, at the pixel m,
/// per mm of approach: [`Camera::area_growth_per_mm`], `2 / z₀` for an untilted pinhole at the distance z₀.
///
/// A face that moves straight towards the camera without any strain lowers the density by `s · depth` to first order,
/// so its gain is 1; a gel that spreads under the face as well has a smaller one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PerspectiveGain {
    /// Dimensionless; 1 is perspective alone.
    pub gain: f64,
}

/// The keys of both laws, as in a profile.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Keys {
    slope_mm: Option<f64>,
    intercept_mm: Option<f64>,
    gain: Option<f64>,
}

impl TryFrom<Keys> for DepthLaw {
    type Error = &'static str;

    fn try_from(keys: Keys) -> Result<Self, Self::Error> {
        match (keys.slope_mm, keys.intercept_mm, keys.gain) {
            (Some(slope_mm), Some(intercept_mm), None) => Ok(Self::Line(DepthLine { slope_mm, intercept_mm })),
            (None, None, Some(gain)) => Ok(Self::Perspective(PerspectiveGain { gain })),
            (None, None, None) => Err("missing slope_mm and intercept_mm, or gain"),
            (_, _, Some(_)) => {
                Err("gain cannot be combined: a line has slope_mm and intercept_mm, perspective has gain")
            }
            (None, ..) => Err("missing slope_mm beside intercept_mm"),
            (_, None, _) => Err("missing intercept_mm beside slope_mm"),
        }
    }
}

impl From<DepthLine> for DepthLaw {
    fn from(line: DepthLine) -> Self {
        Self::Line(line)
    }
}

impl DepthLaw {
    /// Checks that every value is possible.
    ///
    /// # Errors
    ///
    /// [`ParameterError`] names the first value that is not.
    pub fn validate(&self) -> Result<(), ParameterError> {
        match self {
            Self::Line(line) => line.validate(),
            Self::Perspective(PerspectiveGain { gain }) => {
                let is_allowed = gain.is_finite() && *gain > 0.0;
                ParameterError::unless(is_allowed, "depth.density.gain", *gain, "a number above 0")
            }
        }
    }

    /// Whether the law needs the camera.
    #[must_use]
    pub fn needs_camera(&self) -> bool {
        matches!(self, Self::Perspective(_))
    }
}

impl DepthLine {
    /// Checks that the line is finite.
    ///
    /// # Errors
    ///
    /// [`ParameterError`] names the first value that is not.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let (slope, intercept) = (self.slope_mm, self.intercept_mm);
        ParameterError::unless(slope.is_finite(), "depth.density.slope_mm", slope, "any finite length, mm")?;
        ParameterError::unless(intercept.is_finite(), "depth.density.intercept_mm", intercept, "any finite length, mm")
    }

    /// Depth in mm, positive pressed in, of one value of the feature `1 − density`.
    #[must_use]
    pub fn depth_mm(&self, feature: f32) -> f32 {
        self.slope_mm as f32 * feature + self.intercept_mm as f32
    }
}

/// Depth at which perspective alone gives a feature of 1, `1 / s(m)`, mm, at every pixel of an image: 12.5 mm for an
/// untilted pinhole 25 mm away. Not finite where the camera does not see the undeformed surface, or sees it shrink as
/// it comes nearer, as a strong lens does at its edge.
///
/// None if the camera is impossible.
#[must_use]
pub fn perspective_slopes_mm(camera: &CameraParams, (width, height): (usize, usize)) -> Option<Image<f32>> {
    let camera = Camera::new(camera).ok()?;
    let slope = |x: usize, y: usize| {
        let growth = camera.area_growth_per_mm([x as f64, y as f64]).filter(|&growth| growth > 0.0);
        growth.map_or(f32::NAN, |growth| growth.recip() as f32)
    };
    Some(Image::from_fn(width, height, slope))
}

/// A law prepared for images of one size: the per-frame call allocates nothing.
#[derive(Debug, Clone)]
pub struct DepthMap {
    size: (usize, usize),
    form: Form,
}

#[derive(Debug, Clone)]
enum Form {
    Line(DepthLine),
    /// A slope at every pixel, mm; not finite where there is none.
    Slopes(Image<f32>),
}

impl DepthMap {
    /// The law for features of this size, seen by this camera.
    ///
    /// None if the law needs a camera and there is none, or if no pixel of the image shows the surface.
    #[must_use]
    pub fn new(law: &DepthLaw, camera: Option<&CameraParams>, size: (usize, usize)) -> Option<Self> {
        let form = match law {
            DepthLaw::Line(line) => Form::Line(*line),
            DepthLaw::Perspective(PerspectiveGain { gain }) => {
                let mut slopes = perspective_slopes_mm(camera?, size)?;
                slopes.values_mut().iter_mut().for_each(|slope| *slope *= *gain as f32);
                slopes.values().iter().any(|slope| slope.is_finite()).then_some(Form::Slopes(slopes))?
            }
        };
        Some(Self { size, form })
    }

    /// Writes the depth in mm, positive pressed in, at every pixel of `feature`. Nothing is clamped: a bulge reads
    /// negative. Where the law has no slope the depth is 0 and `valid` becomes 0.
    ///
    /// # Panics
    ///
    /// If the images differ in size from the map.
    pub fn depth_into(&self, feature: &Image<f32>, valid: &mut Image<u8>, depth: &mut Image<f32>) {
        assert_eq!([feature.size(), valid.size(), depth.size()], [self.size; 3], "size of feature, validity and depth");
        let to_depth = depth.values_mut().iter_mut().zip(feature.values());
        match &self.form {
            Form::Line(line) => to_depth.for_each(|(depth, &feature)| *depth = line.depth_mm(feature)),
            Form::Slopes(slopes) => {
                for (((depth, &feature), &slope), valid) in to_depth.zip(slopes.values()).zip(valid.values_mut()) {
                    let is_seen = slope.is_finite();
                    *depth = if is_seen { slope * feature } else { 0.0 };
                    *valid &= u8::from(is_seen);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use fingervision_optics::Distortion;

    use super::*;

    const CAMERA: CameraParams = CameraParams {
        focal_length_px: [400.0, 400.0],
        principal_point_px: [1.0, 0.0],
        distortion: Distortion { k1: 0.0, k2: 0.0, p1: 0.0, p2: 0.0, radial: fingervision_optics::Radial::Brown },
        rotation_rad: [0.0; 3],
        translation_mm: [0.0, 0.0, 25.0],
    };

    fn depth(law: &DepthLaw, camera: &CameraParams) -> (Vec<f32>, Vec<u8>) {
        let map = DepthMap::new(law, Some(camera), (3, 1)).unwrap();
        let feature = Image::from_vec(3, 1, vec![-0.1, 0.0, 0.2]).unwrap();
        let (mut valid, mut depth) = (Image::filled(3, 1, 1), Image::filled(3, 1, f32::NAN));
        map.depth_into(&feature, &mut valid, &mut depth);
        (depth.values().to_vec(), valid.values().to_vec())
    }

    fn assert_depths(given: &[f32], expected: [f32; 3]) {
        for (depth, expected) in given.iter().zip(expected) {
            assert!((depth - expected).abs() < 1e-6, "{depth} mm, expected {expected} mm");
        }
    }

    #[test]
    fn the_line_is_not_clamped() {
        let law: DepthLaw = toml::from_str("slope_mm = 15.0\nintercept_mm = 0.5").unwrap();
        law.validate().unwrap();
        let (depth, valid) = depth(&law, &CAMERA);
        assert_depths(&depth, [-1.0, 0.5, 3.5]);
        assert_eq!(valid, [1, 1, 1]);
    }

    #[test]
    fn perspective_gives_the_slope_that_the_camera_distance_has() {
        let law: DepthLaw = toml::from_str("gain = 0.8").unwrap();
        law.validate().unwrap();
        assert_depths(&depth(&law, &CAMERA).0, [-1.0, 0.0, 2.0]);
    }

    #[test]
    fn what_the_camera_does_not_see_is_not_valid() {
        let law = DepthLaw::Perspective(PerspectiveGain { gain: 1.0 });
        // Turned so far that the horizon passes between the pixels.
        let grazing = CameraParams {
            rotation_rad: [0.0, 0.9, 0.0],
            focal_length_px: [1.0, 1.0],
            principal_point_px: [1.0, 0.0],
            ..CAMERA
        };
        let (depth, valid) = depth(&law, &grazing);
        assert_eq!(valid.iter().sum::<u8>(), 2, "{depth:?}");
        assert!(depth.iter().all(|depth| depth.is_finite()), "{depth:?}");
        assert!(DepthMap::new(&law, None, (3, 1)).is_none());
    }

    #[test]
    fn each_law_is_written_as_it_is_read() {
        for text in ["slope_mm = 15.0\nintercept_mm = 0.5\n", "gain = 0.8\n"] {
            let law: DepthLaw = toml::from_str(text).unwrap();
            assert_eq!(toml::to_string(&law).unwrap(), text);
        }
    }

    #[test]
    fn a_mixture_of_laws_is_refused() {
        let refusal = |text: &str| toml::from_str::<DepthLaw>(text).unwrap_err().message().to_owned();
        assert!(refusal("slope_mm = 1.0\ngain = 1.0").starts_with("gain cannot be combined"));
        assert_eq!(refusal("slope_mm = 1.0"), "missing intercept_mm beside slope_mm");
        assert_eq!(refusal("intercept_mm = 1.0"), "missing slope_mm beside intercept_mm");
        assert_eq!(refusal(""), "missing slope_mm and intercept_mm, or gain");
        assert!(refusal("slope = 1.0").contains("unknown field `slope`"), "{}", refusal("slope = 1.0"));
    }

    #[test]
    fn an_impossible_law_is_refused() {
        let error = DepthLine { slope_mm: f64::INFINITY, intercept_mm: 0.0 }.validate().unwrap_err();
        assert_eq!(error.to_string(), "depth.density.slope_mm = inf is out of range: any finite length, mm");
        let error = DepthLine { slope_mm: 1.0, intercept_mm: f64::NAN }.validate().unwrap_err();
        assert_eq!(error.key, "depth.density.intercept_mm");
        for gain in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = DepthLaw::Perspective(PerspectiveGain { gain }).validate().unwrap_err();
            assert_eq!(error.key, "depth.density.gain");
        }
    }
}

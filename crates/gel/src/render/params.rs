use super::RenderError;
use serde::{Deserialize, Serialize};

/// Most pixels along a side of the image.
const MOST_PIXELS: usize = 4096;

/// Largest number of images averaged for a moving frame.
const MOST_SUB_FRAMES: usize = 64;

/// Rendering options: the `[render]` table of a scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RenderParams {
    /// Columns, px.
    pub width: usize,
    /// Rows, px.
    pub height: usize,
    /// Red, green and blue, or grey.
    pub colour: bool,
    /// Standard deviation of the Gaussian blur of the optics, px; 0 is no blur.
    pub blur_px: f64,
    /// The ring light's share of the light, 0 to 1: how much brighter or darker a slope can be.
    pub shading: f64,
    /// The ring light, which shines on the surface from the camera's side.
    pub ring: RingLight,
    /// Darkening of the image off the optical axis, dimensionless: 0 is none, 1 is the fourth power of the cosine.
    pub vignetting: f64,
    /// Standard deviation of the noise on each channel, in grey levels.
    pub noise_levels: f64,
    /// Seed of the noise: the same seed gives the same bytes.
    pub seed: u64,
    /// Red, green and blue where there is no gel, in grey levels.
    pub background: [u8; 3],
    /// Motion blur.
    pub motion_blur: MotionBlur,
}

/// A circle of lamps about the gel's z axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RingLight {
    /// Radius of the circle, mm.
    pub radius_mm: f64,
    /// Its height above the undeformed surface, mm, towards the camera.
    pub height_mm: f64,
}

/// The exposure, during which the surface moves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MotionBlur {
    /// Number of images averaged for a frame; 1 is no blur.
    pub sub_frames: usize,
    /// Exposure time, as a share of the time between frames.
    pub exposure: f64,
}

impl Default for RenderParams {
    fn default() -> Self {
        Self {
            width: 480,
            height: 480,
            colour: true,
            blur_px: 0.7,
            shading: 0.15,
            ring: RingLight::default(),
            vignetting: 0.2,
            noise_levels: 2.0,
            seed: 1,
            background: [10; 3],
            motion_blur: MotionBlur::default(),
        }
    }
}

impl Default for RingLight {
    fn default() -> Self {
        Self { radius_mm: 30.0, height_mm: 5.0 }
    }
}

impl Default for MotionBlur {
    fn default() -> Self {
        Self { sub_frames: 1, exposure: 0.5 }
    }
}

impl RenderParams {
    /// Checks every parameter's range.
    ///
    /// # Errors
    ///
    /// [`RenderError::OutOfRange`] names the first parameter outside its range.
    pub fn validate(&self) -> Result<(), RenderError> {
        let is_size = |size: usize| (1..=MOST_PIXELS).contains(&size);
        let is_length = |length: f64| (1e-3..=1e6).contains(&length);
        let share = "0 to 1";
        let is_share = |value: f64| (0.0..=1.0).contains(&value);
        let (blur, ring) = (self.motion_blur, self.ring);
        let checks = [
            ("width", self.width as f64, is_size(self.width), "1 to 4096 px"),
            ("height", self.height as f64, is_size(self.height), "1 to 4096 px"),
            ("blur_px", self.blur_px, (0.0..=20.0).contains(&self.blur_px), "0 to 20 px"),
            ("shading", self.shading, is_share(self.shading), share),
            ("ring.radius_mm", ring.radius_mm, is_length(ring.radius_mm), "0.001 to 1e6 mm"),
            ("ring.height_mm", ring.height_mm, is_length(ring.height_mm), "0.001 to 1e6 mm"),
            ("vignetting", self.vignetting, is_share(self.vignetting), share),
            ("noise_levels", self.noise_levels, (0.0..=255.0).contains(&self.noise_levels), "0 to 255 grey levels"),
            (
                "motion_blur.sub_frames",
                blur.sub_frames as f64,
                (1..=MOST_SUB_FRAMES).contains(&blur.sub_frames),
                "1 to 64 images",
            ),
            ("motion_blur.exposure", blur.exposure, is_share(blur.exposure), share),
        ];
        match checks.into_iter().find(|&(_, _, is_allowed, _)| !is_allowed) {
            Some((key, value, _, allowed)) => Err(RenderError::OutOfRange { key, value, allowed }),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_is_in_range() {
        assert_eq!(RenderParams::default().validate(), Ok(()));
    }

    #[test]
    fn a_parameter_out_of_range_is_named() {
        let error = RenderParams { shading: 1.5, ..RenderParams::default() }.validate().unwrap_err();
        assert_eq!(error.to_string(), "shading is 1.5: 0 to 1 is allowed");
        let still = MotionBlur { sub_frames: 0, ..MotionBlur::default() };
        assert!(RenderParams { motion_blur: still, ..RenderParams::default() }.validate().is_err());
        assert!(RenderParams { blur_px: f64::NAN, ..RenderParams::default() }.validate().is_err());
    }

    #[test]
    fn a_table_may_leave_out_what_it_does_not_change() {
        let params: RenderParams = toml::from_str("width = 640\nring = { height_mm = 9.0 }").unwrap();
        let ring = RingLight { height_mm: 9.0, ..RingLight::default() };
        assert_eq!(params, RenderParams { width: 640, ring, ..RenderParams::default() });
        assert!(toml::from_str::<RenderParams>("widht = 640").is_err());
    }
}

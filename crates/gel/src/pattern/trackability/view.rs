use fingervision_optics::{Camera, CameraParams, Distortion};

use crate::PatternError;

/// A camera and a gel.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// Columns and rows of its image, px.
    pub size_px: [usize; 2],
    /// Width and height of the gel's surface, mm.
    pub gel_mm: [f64; 2],
    /// Standard deviation of the Gaussian blur of the optics, px.
    pub blur_px: f64,
    /// Standard deviation of the noise on each channel before it is rounded to 8 bits, grey levels.
    pub noise_levels: f64,
    /// Whether there are three channels or one.
    pub colour: bool,
}

impl View {
    /// Straight on, with a pixel of this size on the gel, mm, and a gel that fills the image. Blur, noise and colour are
    /// those of the default simulated sensor: 0.7 px, 2 grey levels, three channels.
    ///
    /// # Errors
    ///
    /// [`PatternError::OutOfRange`] unless the pixel has a size.
    pub fn straight_on(size_px: [usize; 2], mm_per_px: f64) -> Result<Self, PatternError> {
        let refused = || PatternError::OutOfRange {
            key: "mm_per_px",
            value: mm_per_px.to_string(),
            allowed: "a length above 0 mm",
        };
        let params = CameraParams {
            focal_length_px: [mm_per_px.recip(); 2],
            principal_point_px: size_px.map(|size| 0.5 * (size as f64 - 1.0)),
            distortion: Distortion::default(),
            rotation_rad: [0.0; 3],
            translation_mm: [0.0, 0.0, 1.0],
        };
        let camera = Camera::new(&params).map_err(|_| refused())?;
        let gel_mm = size_px.map(|size| 1.1 * size as f64 * mm_per_px);
        Ok(Self { camera, size_px, gel_mm, blur_px: 0.7, noise_levels: 2.0, colour: true })
    }

    /// Checks the values that the camera does not.
    pub(super) fn validate(&self) -> Result<(), PatternError> {
        let checks = [
            ("blur_px", self.blur_px, (0.0..=100.0).contains(&self.blur_px), "0 to 100 px"),
            ("noise_levels", self.noise_levels, (0.0..=255.0).contains(&self.noise_levels), "0 to 255 grey levels"),
        ];
        match checks.into_iter().find(|&(_, _, is_allowed, _)| !is_allowed) {
            Some((key, value, _, allowed)) => Err(PatternError::OutOfRange { key, value: value.to_string(), allowed }),
            None => Ok(()),
        }
    }
}

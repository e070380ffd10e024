use crate::GelError;
use serde::{Deserialize, Serialize};

/// The sheet at rest, and its image.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sheet {
    /// Columns, px.
    pub width: usize,
    /// Rows, px.
    pub height: usize,
    /// Side of a pattern cell, px.
    pub cell_size_px: f64,
    /// Angle by which the pattern is turned about the image centre, clockwise on screen, rad.
    pub rotation_rad: f64,
    /// Darkest and brightest level of a cell's channels, both included, in grey levels.
    pub levels: [u8; 2],
    /// Standard deviation of the Gaussian by which the optics blur, px; 0 blurs nothing.
    pub blur_px: f64,
    /// Standard deviation of the noise on each channel, in grey levels.
    pub noise_levels: f64,
    /// Which pattern: the same seed gives the same cells.
    pub pattern_seed: u64,
}

impl Default for Sheet {
    fn default() -> Self {
        Self {
            width: 610,
            height: 450,
            cell_size_px: 4.0,
            rotation_rad: 1.5_f64.to_radians(),
            levels: [16, 240],
            blur_px: 0.7,
            noise_levels: 2.0,
            pattern_seed: 1,
        }
    }
}

impl Sheet {
    /// The image centre, px: half a pixel off for even sizes.
    #[must_use]
    pub fn centre_px(&self) -> [f64; 2] {
        [self.width, self.height].map(|size| 0.5 * (size as f64 - 1.0))
    }

    /// Checks every parameter's range.
    ///
    /// # Errors
    ///
    /// [`GelError::OutOfRange`] names the first parameter outside its range.
    pub fn validate(&self) -> Result<(), GelError> {
        let finite = "any finite angle";
        let checks = [
            ("width", self.width as f64, self.width > 0, "1 px or more"),
            ("height", self.height as f64, self.height > 0, "1 px or more"),
            ("cell_size_px", self.cell_size_px, (1e-3..=1e6).contains(&self.cell_size_px), "0.001 to 1e6 px"),
            ("rotation_rad", self.rotation_rad, self.rotation_rad.is_finite(), finite),
            ("blur_px", self.blur_px, (0.0..=100.0).contains(&self.blur_px), "0 to 100 px"),
            ("noise_levels", self.noise_levels, (0.0..=255.0).contains(&self.noise_levels), "0 to 255 grey levels"),
        ];
        match checks.into_iter().find(|&(_, _, is_allowed, _)| !is_allowed) {
            Some((name, value, _, allowed)) => Err(GelError::OutOfRange { name, value, allowed }),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_is_in_range() {
        assert_eq!(Sheet::default().validate(), Ok(()));
    }

    #[test]
    fn a_parameter_out_of_range_is_named() {
        let error = Sheet { blur_px: f64::NAN, ..Sheet::default() }.validate().unwrap_err();
        assert_eq!(error.to_string(), "blur_px is NaN: 0 to 100 px is allowed");
    }
}

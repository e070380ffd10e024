//! Renders the camera's 8-bit frame of a sheet under a motion.
//!
//! The order is a camera's: the pattern's exact coverage, the optics' blur, the pixel's area, the light, the noise,
//! then rounding. Every step before rounding is in floating point, and a margin is rendered for the blur, so no pixel
//! depends on the image's size.

use super::{Motion, Sheet};
use crate::blur::{Blur, SUB_PIXELS};
use crate::coverage::mean_colours;
use crate::polygon::Point;
use crate::{ColourPattern, GelError};
use fingervision_image::Image;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;

/// How far beyond the image the pattern reaches before it repeats, px.
const PATTERN_MARGIN_PX: f64 = 64.0;

/// A gain on the image, dimensionless, that changes linearly from the left border to the right one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// Gain at the first column.
    pub left: f32,
    /// Gain at the last column.
    pub right: f32,
}

impl Light {
    /// The light of the reference.
    pub const EVEN: Self = Self::uniform(1.0);

    /// The same gain everywhere.
    #[must_use]
    pub const fn uniform(gain: f32) -> Self {
        Self { left: gain, right: gain }
    }

    fn gain(self, x: usize, width: usize) -> f32 {
        let share = x as f32 / (width.max(2) - 1) as f32;
        self.left + share * (self.right - self.left)
    }
}

/// Draws a sheet's frames. Made once a sheet: it owns the pattern.
#[derive(Debug, Clone)]
pub struct SheetRenderer {
    sheet: Sheet,
    pattern: ColourPattern,
    blur: Blur,
}

impl SheetRenderer {
    /// A renderer with the sheet's own random pattern.
    ///
    /// # Errors
    ///
    /// [`GelError::OutOfRange`] if a parameter of the sheet is out of range.
    pub fn new(sheet: &Sheet) -> Result<Self, GelError> {
        sheet.validate()?;
        let diagonal = (sheet.width as f64).hypot(sheet.height as f64);
        let cells = ((diagonal + 2.0 * PATTERN_MARGIN_PX) / sheet.cell_size_px).ceil().max(3.0) as usize;
        let pattern = ColourPattern::random(cells, cells, sheet.levels, sheet.pattern_seed)?;
        Ok(Self { sheet: sheet.clone(), pattern, blur: Blur::new(sheet.blur_px) })
    }

    /// The sheet.
    #[must_use]
    pub fn sheet(&self) -> &Sheet {
        &self.sheet
    }

    /// The frame after `motion`: 8-bit red, green, blue.
    ///
    /// Each frame of a sequence needs a noise seed of its own, the reference included.
    ///
    /// # Errors
    ///
    /// [`GelError::Folds`] if the motion is not one-to-one.
    pub fn render(&self, motion: &Motion, light: Light, noise_seed: u64) -> Result<Image<[u8; 3]>, GelError> {
        let colours = self.colours(motion)?;
        let mut rng = Pcg64Mcg::seed_from_u64(noise_seed);
        let noise = self.sheet.noise_levels as f32;
        let (width, height) = colours.size();
        Ok(Image::from_fn(width, height, |x, y| {
            let gain = light.gain(x, width);
            colours.at(x, y).map(|level| {
                let deviation: f32 = StandardNormal.sample(&mut rng);
                // The cast saturates: a sensor clips at 0 and 255.
                (gain * level + noise * deviation).round() as u8
            })
        }))
    }

    /// The frame after `motion` in even light, without noise or rounding, in grey levels.
    ///
    /// # Errors
    ///
    /// [`GelError::Folds`] if the motion is not one-to-one.
    pub fn colours(&self, motion: &Motion) -> Result<Image<[f32; 3]>, GelError> {
        motion.validate()?;
        let margin = self.blur.margin();
        let corners = |pixels: usize| pixels * SUB_PIXELS + 2 * margin + 1;
        // The first pixel begins half a pixel before its centre, and the margin before that.
        let corner = |index: usize| (index as f64 - margin as f64) / SUB_PIXELS as f64 - 0.5;
        let corners = Image::from_fn(corners(self.sheet.width), corners(self.sheet.height), |x, y| {
            let (x, y) = motion.reference_point(corner(x), corner(y));
            self.cell_coordinates(x, y)
        });
        Ok(self.blur.apply(&mean_colours(&corners, &self.pattern)))
    }

    /// A reference pixel's place on the pattern, in cells.
    fn cell_coordinates(&self, x: f64, y: f64) -> Point {
        let [centre_x, centre_y] = self.sheet.centre_px();
        let (dx, dy) = (x - centre_x, y - centre_y);
        let (sin, cos) = self.sheet.rotation_rad.sin_cos();
        [(cos * dx + sin * dy) / self.sheet.cell_size_px, (cos * dy - sin * dx) / self.sheet.cell_size_px]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet(width: usize, height: usize) -> Sheet {
        Sheet { width, height, ..Sheet::default() }
    }

    #[test]
    fn a_whole_pixel_shift_moves_the_image() {
        let renderer = SheetRenderer::new(&sheet(60, 40)).unwrap();
        let reference = renderer.colours(&Motion::STILL).unwrap();
        let current = renderer.colours(&Motion::Shift { by_px: [3.0, -2.0] }).unwrap();
        for (x, y) in (3..60).flat_map(|x| (0..38).map(move |y| (x, y))) {
            for (now, before) in current.at(x, y).iter().zip(reference.at(x - 3, y + 2)) {
                assert!((now - before).abs() < 1e-3, "({x}, {y}): {now} and {before}");
            }
        }
    }

    #[test]
    fn light_goes_from_border_to_border() {
        let renderer = SheetRenderer::new(&Sheet { noise_levels: 0.0, levels: [16, 200], ..sheet(80, 20) }).unwrap();
        let colours = renderer.colours(&Motion::STILL).unwrap();
        let lit = renderer.render(&Motion::STILL, Light { left: 0.85, right: 1.15 }, 1).unwrap();
        for (x, gain) in [(0, 0.85), (79, 1.15)] {
            for (lit, colour) in lit.at(x, 7).iter().zip(colours.at(x, 7)) {
                assert!((f32::from(*lit) - gain * colour).abs() <= 0.501);
            }
        }
    }

    #[test]
    fn noise_has_its_standard_deviation_and_its_seed() {
        let renderer = SheetRenderer::new(&Sheet { noise_levels: 2.0, levels: [60, 180], ..sheet(200, 100) }).unwrap();
        let colours = renderer.colours(&Motion::STILL).unwrap();
        let frame = renderer.render(&Motion::STILL, Light::EVEN, 4).unwrap();
        let pairs = frame.values().iter().flatten().zip(colours.values().iter().flatten());
        let variance = pairs.map(|(noisy, clean)| (f32::from(*noisy) - clean).powi(2)).sum::<f32>() / 60_000.0;
        // Rounding adds 1/12.
        assert!((variance - 4.083).abs() < 0.1, "variance {variance}");
        assert_eq!(frame, renderer.render(&Motion::STILL, Light::EVEN, 4).unwrap());
        assert_ne!(frame, renderer.render(&Motion::STILL, Light::EVEN, 5).unwrap());
    }

    #[test]
    fn a_motion_that_folds_is_not_rendered() {
        let renderer = SheetRenderer::new(&sheet(20, 20)).unwrap();
        let folding = Motion::radial_bump([9.5, 9.5], 120.0);
        assert!(matches!(renderer.colours(&folding), Err(GelError::Folds { .. })));
    }
}

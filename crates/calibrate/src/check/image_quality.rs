//! Exposure and focus of a single image, for a person who adjusts the camera.

use fingervision_flow::Picture;
use fingervision_image::{Pixels, Rect};

use super::exposure::{is_black, is_saturated};
use super::thresholds::THRESHOLDS;

/// Distance between the rows that are used for the exposure.
const ROW_STEP: usize = 2;
/// The coarsest pyramid level that the sharpness needs.
const COARSEST_LEVEL: usize = 2;
/// The smallest side of a region, px: two pixels at the coarsest level.
const LEAST_SIDE: usize = 8;

/// Exposure and focus of one image.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ImageQuality {
    /// Mean level, 0 to 255.
    pub mean_level: f64,
    /// Part of the values at the top of their range.
    pub saturated: f64,
    /// Part of the values at the bottom of their range.
    pub black: f64,
    /// [`Picture::sharpness`], dimensionless.
    pub sharpness: f32,
}

impl ImageQuality {
    /// The quality of a region of an image; absent if the region does not fit the image or is too small.
    #[must_use]
    pub fn of(pixels: &Pixels, region: Rect) -> Option<Self> {
        let (columns, rows) = pixels.size();
        if !region.is_inside(columns, rows) || region.width.min(region.height) < LEAST_SIDE {
            return None;
        }
        let mut picture = Picture::new(region.width, region.height, COARSEST_LEVEL, false);
        picture.load(pixels, region).ok()?;
        let (mut count, mut sum, mut black, mut saturated) = (0.0, 0.0, 0.0, 0.0);
        for y in (region.y..region.y + region.height).step_by(ROW_STEP) {
            for value in (region.x..region.x + region.width).flat_map(|x| pixels.levels(x, y)) {
                count += 1.0;
                sum += f64::from(value);
                black += f64::from(u8::from(is_black(value)));
                saturated += f64::from(u8::from(is_saturated(value)));
            }
        }
        let sharpness = picture.sharpness();
        Some(Self { mean_level: sum / count, saturated: saturated / count, black: black / count, sharpness })
    }

    /// What is wrong with the exposure, with the limits of the check of a recording.
    #[must_use]
    pub fn exposure_advice(&self) -> Option<&'static str> {
        let [least, most] = THRESHOLDS.mean_levels;
        if self.saturated > THRESHOLDS.most_clipped || self.mean_level > most {
            return Some("too bright: shorten the exposure, or lower light or gain");
        }
        (self.black > THRESHOLDS.most_clipped || self.mean_level < least)
            .then_some("too dark: lengthen the exposure, or raise the light")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fingervision_image::Image;

    /// Stripes of this width whose edges are ramps of `edge` px.
    fn stripes([dark, bright]: [u8; 2], width: usize, edge: usize) -> Pixels {
        let level = |x: usize| {
            let part = (0..edge).filter(|offset| ((x + offset) / width) % 2 == 1).count() as f32 / edge as f32;
            (f32::from(dark) + part * (f32::from(bright) - f32::from(dark))).round() as u8
        };
        Pixels::Grey8(Image::from_fn(64, 48, |x, _| level(x)))
    }

    fn quality(pixels: &Pixels) -> ImageQuality {
        ImageQuality::of(pixels, Rect::whole(64, 48)).unwrap()
    }

    #[test]
    fn sharpness_grows_with_focus_and_not_with_light() {
        let (sharp, blurred) = (quality(&stripes([50, 150], 16, 1)), quality(&stripes([50, 150], 16, 5)));
        assert!(sharp.sharpness > 1.5 * blurred.sharpness, "{sharp:?} {blurred:?}");
        let brighter = quality(&stripes([60, 200], 16, 5));
        assert!((blurred.sharpness / brighter.sharpness - 1.0).abs() < 0.02, "{blurred:?} {brighter:?}");
        assert!((sharp.mean_level - 100.0).abs() < 1e-9, "{sharp:?}");
    }

    #[test]
    fn light_that_is_wrong_is_named() {
        let advice = |levels| quality(&stripes(levels, 4, 1)).exposure_advice();
        assert_eq!(advice([60, 180]), None);
        assert!(advice([0, 20]).unwrap().starts_with("too dark"));
        assert!(advice([200, 255]).unwrap().starts_with("too bright"));
    }

    #[test]
    fn a_region_that_does_not_fit_or_is_too_small_has_no_quality() {
        let pixels = stripes([0, 9], 4, 1);
        for (width, height, fits) in [(65, 48, false), (64, 7, false), (7, 48, false), (8, 8, true)] {
            assert_eq!(ImageQuality::of(&pixels, Rect::whole(width, height)).is_some(), fits, "{width}x{height}");
        }
    }
}

//! Exposure and focus of a single image, for a person who adjusts the camera.

use fingervision_image::{Pixels, Rect};

use super::exposure::{is_black, is_saturated};
use super::thresholds::THRESHOLDS;

/// Distance between the rows that are used.
const ROW_STEP: usize = 2;

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
    /// Root mean square of the differences between horizontal neighbours, over the standard deviation of all values;
    /// dimensionless. It grows with focus and does not depend on the light. It also grows with noise, and depends on the
    /// pattern, so only values of the same gel can be compared.
    pub sharpness: f64,
}

impl ImageQuality {
    /// The quality of a region of an image; absent if the region does not fit the image or is too small.
    #[must_use]
    pub fn of(pixels: &Pixels, region: Rect) -> Option<Self> {
        let (columns, rows) = pixels.size();
        if !region.is_inside(columns, rows) || region.width < 2 || region.height == 0 {
            return None;
        }
        let (mut count, mut sum, mut squares, mut steps) = (0.0, 0.0, 0.0, 0.0);
        let (mut black, mut saturated) = (0.0, 0.0);
        for y in (region.y..region.y + region.height).step_by(ROW_STEP) {
            for x in region.x..region.x + region.width - 1 {
                let (here, beside) = (pixels.levels(x, y), pixels.levels(x + 1, y));
                for (value, next) in here.into_iter().zip(beside) {
                    black += f64::from(u8::from(is_black(value)));
                    saturated += f64::from(u8::from(is_saturated(value)));
                    let (value, next) = (f64::from(value), f64::from(next));
                    count += 1.0;
                    sum += value;
                    squares += value * value;
                    steps += (next - value) * (next - value);
                }
            }
        }
        let mean_level = sum / count;
        let variance = (squares / count - mean_level * mean_level).max(0.0);
        let sharpness = if variance > 0.0 { (steps / count / variance).sqrt() } else { 0.0 };
        Some(Self { mean_level, saturated: saturated / count, black: black / count, sharpness })
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

    fn stripes(dark: u8, bright: u8, width: usize) -> Pixels {
        let values = (0..64 * 48).map(|at| if ((at % 64) / width).is_multiple_of(2) { dark } else { bright });
        Pixels::Grey8(Image::from_vec(64, 48, values.collect()).unwrap())
    }

    fn quality(pixels: &Pixels) -> ImageQuality {
        ImageQuality::of(pixels, Rect { x: 0, y: 0, width: 64, height: 48 }).unwrap()
    }

    #[test]
    fn sharpness_grows_with_detail_and_not_with_light() {
        let (coarse, fine) = (quality(&stripes(50, 150, 16)), quality(&stripes(50, 150, 4)));
        assert!(fine.sharpness > 1.5 * coarse.sharpness, "{fine:?} {coarse:?}");
        let brighter = quality(&stripes(60, 200, 4));
        assert!((fine.sharpness - brighter.sharpness).abs() < 0.02, "{fine:?} {brighter:?}");
        assert!((fine.mean_level - 100.0).abs() < 5.0);
    }

    #[test]
    fn light_that_is_wrong_is_named() {
        assert_eq!(quality(&stripes(60, 180, 4)).exposure_advice(), None);
        assert!(quality(&stripes(0, 20, 4)).exposure_advice().unwrap().starts_with("too dark"));
        assert!(quality(&stripes(200, 255, 4)).exposure_advice().unwrap().starts_with("too bright"));
        assert_eq!(ImageQuality::of(&stripes(0, 9, 4), Rect { x: 0, y: 0, width: 65, height: 48 }), None);
    }
}

//! The errors of a depth map, by region.

use fingervision_gel::Truth;
use fingervision_image::Image;
use fingervision_optics::Camera;
use serde::Serialize;

use crate::run::{BORDER_MM, BorderBand, Correlation};

/// Mean absolute errors of a depth map, mm.
///
/// Unlike `evaluate`, this counts **every pixel whose truth is visible**, valid or not, so that a method has no
/// advantage from leaving pixels out. A depth that is not a number counts as 0 mm. `trusted` is the error over the
/// valid pixels only.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct DepthScore {
    /// Over the whole image.
    pub everywhere_mm: f64,
    /// In the true contact; NaN if nothing is touched.
    pub inside_mm: f64,
    /// Within 1 mm of the true contact's border, on both sides; NaN if there is none.
    pub border_mm: f64,
    /// Neither in contact nor near its border.
    pub outside_mm: f64,
    /// Over all pixels that the method marks as valid.
    pub trusted_mm: f64,
    /// Part of the visible pixels that the method marks as valid, 0 to 1.
    pub trusted: f64,
    /// Pearson's correlation of estimate and truth; NaN if either is constant.
    pub correlation: f64,
}

/// Computes the errors of depth maps against one truth.
#[derive(Debug)]
pub struct Scorer<'a> {
    truth: &'a Truth,
    near: Vec<bool>,
}

/// A sum and its number of values.
#[derive(Debug, Clone, Copy, Default)]
struct Mean {
    sum: f64,
    count: f64,
}

impl Mean {
    fn push(&mut self, value: f64) {
        self.sum += value;
        self.count += 1.0;
    }

    fn value(self) -> f64 {
        self.sum / self.count
    }
}

impl<'a> Scorer<'a> {
    /// A scorer for a truth that this camera sees.
    #[must_use]
    pub fn new(truth: &'a Truth, camera: &Camera) -> Self {
        let depth = truth.depth.values();
        let mut band = BorderBand::new(camera, truth.depth.size(), BORDER_MM);
        let near = band.find(truth.contact.values(), |pixel| depth[pixel].is_finite()).to_vec();
        Self { truth, near }
    }

    /// The errors of a depth map on the truth's grid. `valid` is 1 where the method marks it as valid.
    ///
    /// # Panics
    ///
    /// If the sizes differ.
    #[must_use]
    pub fn score(&self, depth_mm: &Image<f32>, valid: &Image<u8>) -> DepthScore {
        let truth = self.truth;
        assert_eq!((depth_mm.size(), valid.size()), (truth.depth.size(), truth.depth.size()), "sizes of the maps");
        let (mut everywhere, mut inside, mut border) = (Mean::default(), Mean::default(), Mean::default());
        let (mut outside, mut trusted) = (Mean::default(), Mean::default());
        let mut pairs = Correlation::default();
        for pixel in 0..truth.depth.values().len() {
            let true_mm = f64::from(truth.depth.values()[pixel]);
            if truth.visible.values()[pixel] == 0 || !true_mm.is_finite() {
                continue;
            }
            let estimate_mm = f64::from(depth_mm.values()[pixel]);
            let estimate_mm = if estimate_mm.is_finite() { estimate_mm } else { 0.0 };
            let error = (estimate_mm - true_mm).abs();
            everywhere.push(error);
            pairs.push(estimate_mm, true_mm);
            let is_inside = truth.contact.values()[pixel] != 0;
            if is_inside {
                inside.push(error);
            }
            if self.near[pixel] {
                border.push(error);
            }
            if !is_inside && !self.near[pixel] {
                outside.push(error);
            }
            if valid.values()[pixel] != 0 {
                trusted.push(error);
            }
        }
        DepthScore {
            everywhere_mm: everywhere.value(),
            inside_mm: inside.value(),
            border_mm: border.value(),
            outside_mm: outside.value(),
            trusted_mm: trusted.value(),
            trusted: trusted.count / everywhere.count,
            correlation: pairs.coefficient().unwrap_or(f64::NAN),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fingervision_optics::{CameraParams, Distortion};

    const SIZE: (usize, usize) = (40, 30);

    /// A contact of 10 × 10 px, 2 mm deep, seen at 0.25 mm a pixel.
    fn truth() -> Truth {
        let (width, height) = SIZE;
        let is_inside = |x: usize, y: usize| (15..25).contains(&x) && (10..20).contains(&y);
        Truth {
            flow: Image::filled(width, height, [0.0; 2]),
            depth: Image::from_fn(width, height, |x, y| if is_inside(x, y) { 2.0 } else { 0.0 }),
            displacement: Image::filled(width, height, [0.0; 3]),
            contact: Image::from_fn(width, height, |x, y| u8::from(is_inside(x, y))),
            visible: Image::from_fn(width, height, |x, _| u8::from(x > 0)),
        }
    }

    fn camera() -> Camera {
        Camera::new(&CameraParams {
            focal_length_px: [100.0; 2],
            principal_point_px: [19.5, 14.5],
            distortion: Distortion::default(),
            rotation_rad: [0.0; 3],
            translation_mm: [0.0, 0.0, 25.0],
        })
        .unwrap()
    }

    #[test]
    fn every_seen_pixel_counts_trusted_or_not() {
        let (truth, camera) = (truth(), camera());
        let scorer = Scorer::new(&truth, &camera);
        let nothing = Image::filled(SIZE.0, SIZE.1, 0.0);
        let outside = Image::from_fn(SIZE.0, SIZE.1, |x, y| 1 - truth.contact.at(x, y));
        let score = scorer.score(&nothing, &outside);
        let seen = 39.0 * 30.0;
        assert!((score.everywhere_mm - 200.0 / seen).abs() < 1e-12, "{score:?}");
        assert_eq!((score.inside_mm, score.outside_mm, score.trusted_mm), (2.0, 0.0, 0.0));
        assert!((score.trusted - (seen - 100.0) / seen).abs() < 1e-12 && score.correlation.is_nan());
        // Within 4 px of the border: all of the contact but its inner 2 × 2 px.
        assert!(score.border_mm > 0.5 && score.border_mm < 1.0, "{score:?}");
    }

    #[test]
    fn the_truth_itself_is_right_and_a_gap_is_not() {
        let (truth, camera) = (truth(), camera());
        let scorer = Scorer::new(&truth, &camera);
        let all = Image::filled(SIZE.0, SIZE.1, 1);
        let score = scorer.score(&truth.depth, &all);
        assert_eq!((score.everywhere_mm, score.border_mm, score.trusted), (0.0, 0.0, 1.0));
        assert!((score.correlation - 1.0).abs() < 1e-12);
        let gap = Image::filled(SIZE.0, SIZE.1, f32::NAN);
        assert!((scorer.score(&gap, &all).inside_mm - 2.0).abs() < 1e-12);
    }
}

//! The optics' blur and the pixel's own area, in one separable step.
//!
//! Optics blur before the sensor samples. Blurring whole pixels instead would first alias all detail finer than two
//! pixels into the image, and a tracker would find shifts up to 0.005 px too close to whole pixels. So the pattern is
//! sampled by area with [`SUB_PIXELS`] parts per pixel side, a Gaussian blurs the parts, and each pixel is the mean of
//! its own.
//!
//! The parts must extend beyond the image by [`Blur::margin`] on every side, so that the border is as accurate as the
//! middle.

use fingervision_image::Image;

/// Parts along a pixel's side: with two, the bias left is below 0.001 px for a blur of 0.7 px.
pub(crate) const SUB_PIXELS: usize = 2;

/// Where the Gaussian is cut, in standard deviations.
const REACH: f64 = 4.0;

/// A pixel's weights of the parts along one axis, summing to 1.
#[derive(Debug, Clone)]
pub(crate) struct Blur {
    weights: Vec<f32>,
}

impl Blur {
    /// A Gaussian of standard deviation `sigma_px`, in whole pixels.
    pub(crate) fn new(sigma_px: f64) -> Self {
        let sigma = sigma_px * SUB_PIXELS as f64;
        let reach = (REACH * sigma).ceil() as i32;
        let gaussian = |k: i32| if k == 0 { 1.0 } else { (-0.5 * (f64::from(k) / sigma).powi(2)).exp() };
        let gaussian: Vec<f64> = (-reach..=reach).map(gaussian).collect();
        let mut weights = vec![0.0; gaussian.len() - 1 + SUB_PIXELS];
        for own in 0..SUB_PIXELS {
            weights[own..].iter_mut().zip(&gaussian).for_each(|(weight, gaussian)| *weight += gaussian);
        }
        let total: f64 = weights.iter().sum();
        Self { weights: weights.iter().map(|weight| (weight / total) as f32).collect() }
    }

    /// Number of parts needed before the first pixel's own and after the last pixel's.
    pub(crate) fn margin(&self) -> usize {
        (self.weights.len() - SUB_PIXELS) / 2
    }

    /// A pixel's weights of the parts along one axis, from the first to the last with a weight.
    pub(crate) fn weights(&self) -> &[f32] {
        &self.weights
    }

    /// The image of whole pixels.
    pub(crate) fn apply(&self, parts: &Image<[f32; 3]>) -> Image<[f32; 3]> {
        let [width, height] = [parts.width(), parts.height()].map(|size| (size - 2 * self.margin()) / SUB_PIXELS);
        let rows = Image::from_fn(width, parts.height(), |x, y| self.mean(|k| parts.at(SUB_PIXELS * x + k, y)));
        Image::from_fn(width, height, |x, y| self.mean(|k| rows.at(x, SUB_PIXELS * y + k)))
    }

    fn mean(&self, value: impl Fn(usize) -> [f32; 3]) -> [f32; 3] {
        let mut mean = [0.0; 3];
        for (k, weight) in self.weights.iter().enumerate() {
            for (mean, value) in mean.iter_mut().zip(value(k)) {
                *mean += weight * value;
            }
        }
        mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_point_response_is_as_wide_as_the_optics_and_the_pixel() {
        let blur = Blur::new(0.7);
        let middle = 0.5 * (blur.weights.len() as f64 - 1.0);
        let moment = |power| {
            let terms = blur.weights.iter().enumerate();
            terms.map(|(k, weight)| f64::from(*weight) * (0.5 * (k as f64 - middle)).powi(power)).sum::<f64>()
        };
        assert!((moment(0) - 1.0).abs() < 1e-6 && moment(1).abs() < 1e-6);
        // Two parts, a quarter of a pixel on either side of the middle, have a variance of 1/16 px².
        assert!((moment(2) - 0.49 - 0.0625).abs() < 1e-3, "variance {}", moment(2));
    }

    #[test]
    fn a_ramp_keeps_its_place() {
        let blur = Blur::new(0.7);
        assert_eq!(blur.margin(), 6);
        // Part k lies at (k − 6)/2 − ¼ px.
        let place = |k: usize| (k as f32 - 6.0) / 2.0 - 0.25;
        let pixels = blur.apply(&Image::from_fn(32, 22, |x, y| [place(x), place(y), 1.0]));
        assert_eq!(pixels.size(), (10, 5));
        for (x, y) in (0..10).flat_map(|x| (0..5).map(move |y| (x, y))) {
            let expected = [x as f32, y as f32, 1.0];
            let misses = pixels.at(x, y).into_iter().zip(expected).map(|(value, expected)| (value - expected).abs());
            assert!(misses.fold(0.0, f32::max) < 1e-5, "({x}, {y}): {:?}", pixels.at(x, y));
        }
    }

    #[test]
    fn without_optics_a_pixel_is_the_mean_of_its_parts() {
        let parts = Image::from_fn(6, 4, |x, y| [x as f32, y as f32, 1.0]);
        let pixels = Blur::new(0.0).apply(&parts);
        assert_eq!(pixels, Image::from_fn(3, 2, |x, y| [2.0 * x as f32 + 0.5, 2.0 * y as f32 + 0.5, 1.0]));
    }
}

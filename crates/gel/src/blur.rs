//! The optics' blur: a separable Gaussian that uses up a margin.
//!
//! The image must come with [`Blur::margin`] more pixels on every side than the result has, so the border is as right
//! as the middle.

use fingervision_image::Image;

/// Where the Gaussian is cut, in standard deviations.
const REACH: f64 = 4.0;

/// A Gaussian sampled at whole pixels, its weights summing to 1.
#[derive(Debug, Clone)]
pub(crate) struct Blur {
    weights: Vec<f32>,
}

impl Blur {
    pub(crate) fn new(sigma_px: f64) -> Self {
        let reach = (REACH * sigma_px).ceil() as i32;
        let weight = |k: i32| if k == 0 { 1.0 } else { (-0.5 * (f64::from(k) / sigma_px).powi(2)).exp() };
        let total: f64 = (-reach..=reach).map(weight).sum();
        Self { weights: (-reach..=reach).map(|k| (weight(k) / total) as f32).collect() }
    }

    /// Pixels on every side that the blur uses up.
    pub(crate) fn margin(&self) -> usize {
        self.weights.len() / 2
    }

    /// The blurred image, smaller by the margin on every side.
    pub(crate) fn apply(&self, image: &Image<[f32; 3]>) -> Image<[f32; 3]> {
        let (width, height) = image.size();
        let across = 2 * self.margin();
        let rows = Image::from_fn(width - across, height, |x, y| self.mean(|k| image.at(x + k, y)));
        Image::from_fn(width - across, height - across, |x, y| self.mean(|k| rows.at(x, y + k)))
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
    fn a_point_becomes_a_gaussian_of_the_right_width() {
        let blur = Blur::new(0.7);
        assert_eq!(blur.margin(), 3);
        let image = Image::from_fn(19, 17, |x, y| if (x, y) == (9, 8) { [1.0, 2.0, 0.0] } else { [0.0; 3] });
        let blurred = blur.apply(&image);
        assert_eq!(blurred.size(), (13, 11));
        let moment = |power| {
            let values = (0..13 * 11).map(|k| (k % 13, k / 13));
            values.map(|(x, y)| f64::from(blurred.at(x, y)[0]) * (x as f64 - 6.0).powi(power)).sum::<f64>()
        };
        assert!((moment(0) - 1.0).abs() < 1e-6 && moment(1).abs() < 1e-6);
        // Sampling so narrow a Gaussian at whole pixels takes 0.0012 from its variance.
        assert!((moment(2) - 0.49).abs() < 2e-3, "variance {}", moment(2));
    }

    #[test]
    fn no_width_blurs_nothing() {
        let image = Image::from_fn(5, 4, |x, y| [x as f32, y as f32, 1.0]);
        assert_eq!(Blur::new(0.0).apply(&image), image);
    }
}

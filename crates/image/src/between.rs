//! The value of an image between its pixels.

use crate::Image;

/// A place between the pixels of an image of a certain size, clamped to it, where images are bilinear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Between {
    left: usize,
    top: usize,
    right_part: f32,
    lower_part: f32,
}

impl Between {
    /// The place at `(x, y)`, px, of an image of at least 2×2 px.
    #[must_use]
    #[inline]
    pub fn clamped((x, y): (f32, f32), (width, height): (usize, usize)) -> Self {
        let (x, y) = (x.clamp(0.0, (width - 1) as f32), y.clamp(0.0, (height - 1) as f32));
        let (left, top) = ((x as usize).min(width - 2), (y as usize).min(height - 2));
        Self { left, top, right_part: x - left as f32, lower_part: y - top as f32 }
    }

    /// The same; none if the point lies outside the image, beyond the centres of its outer pixels.
    #[must_use]
    #[inline]
    pub fn inside((x, y): (f32, f32), (width, height): (usize, usize)) -> Option<Self> {
        let is_inside = x >= 0.0 && y >= 0.0 && x <= (width - 1) as f32 && y <= (height - 1) as f32;
        is_inside.then(|| Self::clamped((x, y), (width, height)))
    }

    /// The value there.
    #[must_use]
    #[inline]
    pub fn sample(self, image: &Image<f32>) -> f32 {
        let across = |row: &[f32]| row[self.left] + self.right_part * (row[self.left + 1] - row[self.left]);
        let (above, below) = (across(image.row(self.top)), across(image.row(self.top + 1)));
        above + self.lower_part * (below - above)
    }

    /// Column and row of the nearest pixel.
    #[must_use]
    pub fn nearest(self) -> (usize, usize) {
        (self.left + usize::from(self.right_part >= 0.5), self.top + usize::from(self.lower_part >= 0.5))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_is_read_as_it_is_and_its_border_beyond() {
        let image = Image::from_fn(5, 4, |x, y| x as f32 + 10.0 * y as f32);
        for ((x, y), value) in [((1.25, 2.5), 26.25), ((4.0, 3.0), 34.0), ((-3.0, 1.0), 10.0), ((9.0, 9.0), 34.0)] {
            let sampled = Between::clamped((x, y), image.size()).sample(&image);
            assert!((sampled - value).abs() < 1e-5, "({x}, {y}): {sampled} instead of {value}");
        }
        assert_eq!(Between::clamped((1.5, 2.25), image.size()).nearest(), (2, 2));
    }

    #[test]
    fn outside_there_is_no_place() {
        assert!(Between::inside((4.0, 0.0), (5, 4)).is_some());
        for place in [(4.01, 0.0), (-0.01, 0.0), (0.0, 3.5), (f32::NAN, 0.0)] {
            assert!(Between::inside(place, (5, 4)).is_none(), "{place:?}");
        }
    }
}
